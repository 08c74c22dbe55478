// LAS files made byte by byte, as the tables of the ASPRS LAS 1.4 R15 specification lay them out; our writer has no
// part in them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace curv {

struct SampleRecord {
  std::string user_id;
  uint16_t id;
  std::string payload;
};

// A file to be made. What is changed here, or in the bytes that come out, makes a file wrong in one place.
struct SampleLas {
  int minor_version = 2;
  int format = 0;
  double scale[3] = {0.01, 0.01, 0.001};
  double offset[3] = {500000.0, 4500000.0, 0.0};
  std::vector<SampleRecord> records;
  std::vector<SampleRecord> extended_records;
  std::vector<std::string> points;  // one record each, extra bytes included
  size_t waveforms_in = 0;          // which extended record holds waveform packets, counted from 1; 0: none

  std::string Bytes() const;
};

// Returns record i of a format, whose attributes all differ from each other, followed by extra bytes.
//   raw X = 1000 + 7 i, Y = -2000 + i, Z = 50 i; intensity 40000 + i; return 2 of 3; scan direction 1; edge 0;
//   classification 2 + i, withheld 0, key point 1; scan angle -30 + i; user data 77; point source 600 + i;
//   gps_time 1.25e8 + i / 8; red green blue 256, 65535, 10 + i; nir 30000 + i;
//   waveform packet: descriptor 1, offset 60 + 2^40 i, 64 bytes, location 0.5, direction 0.25 -0.5 1.
std::string SamplePoint(int format, int i, const std::string& extra = "");

// Returns a file of two points of the format, in the oldest version that has it.
SampleLas SmallLas(int format);

// Returns a descriptor of extra bytes (192 bytes).
std::string Descriptor(int data_type, const std::string& name, int options = 0, double scale = 0.0,
                       double offset = 0.0);

}  // namespace curv
