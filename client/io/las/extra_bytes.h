// Describes the attributes that LAS points have beyond those of their format (ASPRS LAS 1.4 R15, "Extra Bytes").
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "client/io/las/las_fields.h"
#include "client/io/las/las_frame.h"
#include "client/io/point_table.h"

namespace curv {

inline constexpr size_t kLasDescriptorBytes = 192;
// A record's payload has at most 65,535 bytes.
inline constexpr size_t kMaxLasExtras = 341;
inline constexpr size_t kMaxLasName = 32;

// Takes descriptors apart for points with `extra_bytes` bytes beyond their format. Bytes that none describes come as
// undocumented ones, at most 1,024 of them. Columns get names that `used` does not have, and are added to it:
// normal_x normal_y normal_z become nx ny nz. What has no place in a table is told in `notes`.
std::vector<LasExtra> ReadDescriptors(std::string_view descriptors, size_t extra_bytes, std::set<std::string>& used,
                                      std::vector<std::string>& notes);

// Returns the attribute's name in the file.
std::string_view NameOf(const LasExtra& extra);

// Returns the bytes that the attribute takes in a point.
size_t BytesOf(const LasExtra& extra);

// Returns its fields, parallel to its columns. `offset` is where its first byte lies in a record.
std::vector<LasField> FieldsOf(const LasExtra& extra, size_t offset);

// Describes a column of a table: its kind, and its name in at most 32 bytes that `used` does not have, and which are
// added to it. nx ny nz become normal_x normal_y normal_z.
LasExtra DescribeColumn(const Column& column, std::set<std::string>& used);

// Describes `count` bytes of which nothing is known. REQUIRES: 1 <= count <= 255.
LasExtra DescribeUndocumented(size_t count);

}  // namespace curv
