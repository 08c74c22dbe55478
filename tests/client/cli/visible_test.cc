#include <gtest/gtest.h>

#include "client/cli/command.h"

namespace curv {
namespace {

TEST(VisibleTest, EscapesWhatATerminalWouldObey) {
  EXPECT_EQ(Visible("a\x1b[2Jb\r\b\x7f"), "a\\x1b[2Jb\\x0d\\x08\\x7f");
  EXPECT_EQ(Visible("\xc2\x9b"
                    "31m"),
            "\\x9b31m")
      << "the control sequence introducer in UTF-8";
}

TEST(VisibleTest, KeepsTextAndItsLines) {
  EXPECT_EQ(Visible("Gr\xc3\xb6\xc3\x9f"
                    "e 1\n\t2.ply"),
            "Gr\xc3\xb6\xc3\x9f"
            "e 1\n\t2.ply");
}

TEST(ShellWordTest, IsQuotedWhereAShellWouldReadItOtherwise) {
  EXPECT_EQ(ShellWord("/data/plan-1_a.b"), "/data/plan-1_a.b");
  EXPECT_EQ(ShellWord("my plan"), "'my plan'");
  EXPECT_EQ(ShellWord("$(rm x)"), "'$(rm x)'");
  EXPECT_EQ(ShellWord("it's"), "'it'\\''s'");
  EXPECT_EQ(ShellWord(""), "''");
}

}  // namespace
}  // namespace curv
