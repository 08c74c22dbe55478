"""Clouds in text, as people and programs write them. No server is needed."""

import pathlib
import tempfile
import unittest

import numpy as np

from curvd_client.files import read_cloud


class TextFilesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def read(self, text, kind="xyz"):
        file = self.folder / f"cloud.{kind}"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_cloud(file)

    def expect(self, text, positions, normals=None, kind="xyz"):
        with self.subTest(text):
            read = self.read(text, kind)
            np.testing.assert_array_equal(read[0], positions)
            if normals is None:
                self.assertIsNone(read[1])
            else:
                np.testing.assert_array_equal(read[1], normals)

    def test_names_are_the_first_line_of_a_table(self):
        self.expect("x,y,z\n1,2,3\n4,5,6\n", [[1, 2, 3], [4, 5, 6]], kind="csv")
        self.expect("\ufeff\"name\", \"Z\",Y,X\r\n\"#5\",3,2,1\r\n\r\n", [[1, 2, 3]], kind="csv")
        self.expect(",x,y,z,nx,ny,nz,,\n7,1,2,3,0,0,1,,\n", [[1, 2, 3]], [[0, 0, 1]], kind="csv")
        self.expect("name\tx\ty\tz\tgps time\nwall 3\t1\t2\t3\t\n", [[1, 2, 3]], kind="txt")
        self.expect("x,y,z,name\n1,2,3,a_\u00e9\n", [[1, 2, 3]], kind="csv")
        self.expect("x;y;z\n1;2;3\n", [[1, 2, 3]], kind="csv")
        self.expect("normal_x,normal_y,normal_z,x,y,z\n0,0,1,1,2,3\n", [[1, 2, 3]], [[0, 0, 1]], kind="csv")
        self.expect("x,y,z,NormalX,NormalY,NormalZ\n1,2,3,0,0,1\n", [[1, 2, 3]], [[0, 0, 1]], kind="csv")
        self.expect("x,y,z,n_x,N_Y,n_z\n1,2,3,0,0,1\n", [[1, 2, 3]], [[0, 0, 1]], kind="csv")
        self.expect("stra\xdfe,x,y,z\n1,1,2,3\n".encode("latin-1"), [[1, 2, 3]], kind="csv")

    def test_delimiters_in_quotes_separate_nothing(self):
        self.expect('"X","Y","Z","a,b"\n1,2,3,4\n', [[1, 2, 3]], kind="csv")
        self.expect('"a;b,c",x,y,z\n"5, ""6""",1,"2",3\n,1,2,3\n', [[1, 2, 3], [1, 2, 3]], kind="csv")
        self.expect('"a,b";x;y;z\n "4;5" ;1;2;3\n', [[1, 2, 3]], kind="csv")

    def test_colors_of_other_ranges_are_no_normals(self):
        for rows, words in (
            ("1 2 3 0.1 0.2 0.3\n", "the vector of point 0 has the length 0.374166"),
            ("1 2 3 0 0 1\n1 2 3 60000 9 9\n", "the vector of point 1 has the length 60000"),
            ("1 2 3 0 0 0 7\n", "no point has a vector there"),
        ):
            with self.subTest(rows), self.assertWarnsRegex(UserWarning, f"columns 4 to 6 are no normals: {words}"):
                self.assertIsNone(self.read(rows)[1])
        file = self.folder / "cloud.npy"
        np.save(file, [[1, 2, 3, 0.1, 0.2, 0.3]])
        with self.assertWarnsRegex(UserWarning, "cloud.npy: .* save them as the array normals"):
            self.assertIsNone(read_cloud(file)[1])
        self.expect("1 2 3 0 0 0.95\n1 2 3 0 0 0\n", [[1, 2, 3], [1, 2, 3]], [[0, 0, 0.95], [0, 0, 0]])

    def test_a_comment_names_columns_only_where_it_is_a_header(self):
        self.expect("# x y z nx ny nz\n1 2 3 0 0 1\n", [[1, 2, 3]], [[0, 0, 1]])
        self.expect("//X Y Z Nx Ny Nz\n1 2 3 0 0 1\n", [[1, 2, 3]], [[0, 0, 1]], kind="asc")
        self.expect("# x y z intensity nx ny nz\n1 2 3 9 0 0 1 # here\n", [[1, 2, 3]], [[0, 0, 1]])
        self.expect("# id,x,y,z,a,b\n7,1,2,3,4,5\n", [[1, 2, 3]], kind="csv")
        self.expect("#,x,y,z,a,b\n7,1,2,3,4,5\n", [[1, 2, 3]], kind="csv")
        for prose in ("the axes are x y z in metres", "swap x and z, of which", "written on 3 May at noon", "the the wall is a wall"):
            self.expect(f"# {prose}\n1 2 3 0 0 1\n", [[1, 2, 3]], [[0, 0, 1]])
        self.expect("# my scan file\n1,2,3\n", [[1, 2, 3]], kind="csv")

    def test_without_names_places_tell(self):
        with self.assertWarns(UserWarning):
            self.expect("2\n1 2 3 0.5 9 9 9\n4 5 6 0.5 9 9 9\n", [[1, 2, 3], [4, 5, 6]], kind="pts")
        self.expect("1 2 3 10 20 30\n", [[1, 2, 3]])
        self.expect("1 2 3 0 0 1 50\n", [[1, 2, 3]], [[0, 0, 1]])
        self.expect("1\t2\t3\n", [[1, 2, 3]])
        self.expect("1;2;3\n", [[1, 2, 3]])

    def test_what_is_no_table_is_refused_by_its_line(self):
        for text, words in (
            ("x,y,z\n1,2,3\n1,2,3,4\n", "line 3 has 4 values, and there are 3 columns"),
            ("x,y,z\n1,2,three\n", 'line 2: "three" is no number'),
            ("x,y,z,a_b\n1_000,2,3,4\n", 'line 2: "1_000" is no number'),
            ("x,y,z\n1,2,\n", 'line 2: "" is no number'),
            ("x;y;z\n1,5;2,5;3,5\n", 'line 2: "1,5" is no number'),
            ("x,y,z\n1\"2,3,4\n", 'line 2: "1"2" is no number'),
            ("lon,lat,h\n1,2,3\n", "it has lon, lat, h; there must be x and y and z"),
            ("x,y,z\n1,2,3\n".encode("utf-16"), "line 1 has bytes of 0, as text in UTF-16 has"),
            ("1 2 3\n".encode("utf-16-be"), "line 1 has bytes of 0"),
            ("x,y,z\n# 1,2,3\n", "is no number|columns"),
            ("x,y,z,x\n1,2,3,4\n", "two columns have the name x"),
            ("x,y,nz\n1,2,3\n", "it has x, y, nz; there must be"),
            ("1 2 3\n4 5\n", "line 2 has 2 values, and there are 3 columns"),
            ("1 2 3\n\n4 5 six\n", 'line 3: "six" is no number'),
            ("3\n1 2 3\n4 5 6\n", "declares 3 points, and it holds 2"),
            ("# id x y z a b\n1 2 3 4 5 6\n", '"id x y z a b" has a word for each column'),
            ("# z y x\n1 2 3\n", "does not begin with x y z"),
            ("1 2\n3 4\n", "must be .N, 3."),
            ("x,y,z\n", "no points"),
            ("# x y z\n", "no points"),
            ("", "no points"),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, words):
                self.read(text)


if __name__ == "__main__":
    unittest.main()
