#pragma once

// NIfTI and NRRD files of known values, for the tests of src/scan.

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "psivox/error.h"
#include "psivox/vdb.h"
#include "scan/scan.h"
#include "thrown.h"
#include "vdb/reader.h"

namespace psivox::test {

namespace fs = std::filesystem;

inline const glm::ivec3 small{11, 9, 10};  // not all multiples of 8

template <typename T>
void put(std::string& bytes, std::size_t at, T value, bool big) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if (big) std::ranges::reverse(raw);
  bytes.replace(at, sizeof(T), raw.data(), sizeof(T));
}

/// What a voxel holds: 0 in places, a fraction nowhere.
inline int stored_value(const glm::ivec3& v, int c, int frame) {
  if (v.x < 2) return 0;
  return (7 * v.x + 5 * v.y + 3 * v.z + 11 * c + 13 * frame) % 100 + 1;
}

/// The values in the order x, y, z, frame, channel, or with the channels first.
template <typename T>
std::string values_of_type(bool big, int channels = 1, bool interleaved = false, int frames = 1) {
  std::string bytes;
  const int outer = interleaved ? 1 : channels, inner = interleaved ? channels : 1;
  for (int d = 0; d < outer; ++d)
    for (int f = 0; f < frames; ++f)
      for (glm::ivec3 v(0); v.z < small.z; ++v.z)
        for (v.y = 0; v.y < small.y; ++v.y)
          for (v.x = 0; v.x < small.x; ++v.x)
            for (int c = 0; c < inner; ++c) {
              bytes.append(sizeof(T), '\0');
              put(bytes, bytes.size() - sizeof(T), T(stored_value(v, c + d, f)), big);
            }
  return bytes;
}

inline std::string gzipped(const std::string& bytes) {
  std::string packed(bytes.size() + 1000, '\0');
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = uInt(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// A NIfTI header with the sform x' = -2x+20, y' = 3y-5, z' = 4z+y.
inline std::string nifti_header(bool second, bool big, int datatype, std::vector<int> dim) {
  std::string bytes(second ? 544 : 352, '\0');
  put<std::int32_t>(bytes, 0, second ? 540 : 348, big);
  dim.insert(dim.begin(), int(dim.size()));
  const float rows[3][4] = {{-2, 0, 0, 20}, {0, 3, 0, -5}, {0, 1, 4, 0}};
  for (std::size_t i = 0; i < dim.size(); ++i) {
    if (second)
      put<std::int64_t>(bytes, 16 + 8 * i, dim[i], big);
    else
      put<std::int16_t>(bytes, 40 + 2 * i, std::int16_t(dim[i]), big);
  }
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) {
      if (second)
        put<double>(bytes, 400 + 32 * r + 8 * c, double(rows[r][c]), big);
      else
        put<float>(bytes, 280 + 16 * r + 4 * c, rows[r][c], big);
    }
  put<std::int16_t>(bytes, second ? 12 : 70, std::int16_t(datatype), big);
  if (second) {
    bytes.replace(4, 8, std::string("n+2\0\r\n\032\n", 8));
    put<std::int64_t>(bytes, 168, 544, big);
    put<std::int32_t>(bytes, 348, 1, big);
  } else {
    bytes.replace(344, 3, "n+1");
    put<float>(bytes, 108, 352, big);
    put<std::int16_t>(bytes, 254, 1, big);
    bytes[123] = 2;
  }
  return bytes;
}

inline std::vector<int> dims(std::vector<int> more = {}) {
  std::vector<int> all{small.x, small.y, small.z};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

inline std::string nrrd(const std::string& type, const std::string& more) {
  return "NRRD0004\n# made\ntype: " + type + "\ndimension: 3\nsizes: 11 9 10\n" +
         "key:=value\nspace: left-posterior-superior\n" +
         "space directions: (2,0,0) (0,-3,1) (0,0,4)\nspace origin: (-20, 5, 0)\n" + more;
}

/// What reading a file refuses; empty if it is read. In place it must be refused or read alike.
inline std::string refusal_of(const fs::path& path) {
  const auto read = [&](const std::function<Field()>& how) -> std::string {
    try {
      how();
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ExitCode::input || error.code() == ExitCode::memory)
          << error.what();
      EXPECT_FALSE(has(error.what(), "\n"));
      return error.what();
    }
    return {};
  };
  const std::string here = read([&] {
    const auto file = std::make_shared<FileBlocks>(path);
    const std::string data = scan::data_path(*file);
    const auto reader =
        vdb::open_reader(file, data.empty() ? nullptr : std::make_shared<FileBlocks>(data));
    return reader->read(reader->facts().grids.at(0).name, {.role = GridRole::data});
  });
  const std::string there = read([&] {
    const VolumeFile file(path);
    return file.read(file.names().at(0), {.role = GridRole::data});
  });
  EXPECT_EQ(here.empty(), there.empty()) << here << there;
  return there;
}

}  // namespace psivox::test
