// NIfTI and NRRD files that lie or are not read: an error in place and in a guarded process.

#include <random>

#include "scan_made_files.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox::test {
namespace {

TEST(Scans, WhatIsNotReadIsNamed) {
  const auto nifti = [](int datatype) {
    return nifti_header(false, false, datatype, dims()) + std::string(16000, '\1');
  };
  std::string nowhere = nifti(2), analyze = nifti(2), cifti = nifti(2);
  cifti.replace(68, 2, "\xba\x0b");  // the intent 3002
  for (std::size_t i = 280; i < 328; ++i) nowhere[i] = 0;
  analyze[344] = 0;
  const std::string raw = "encoding: raw\n", uchar = values_of_type<std::uint8_t>(false);
  const std::string packed = gzipped(uchar);
  std::string wrong_sum = packed;
  wrong_sum[wrong_sum.size() - 8] ^= 1;
  const std::pair<std::string, std::string> all[] = {
      {nifti(32), "complex"},
      {nifti(1), "single bits"},
      {nifti(1536), "128 bits"},
      {nifti(7), "unknown type 7"},
      {nowhere, "no volume"},
      {analyze, "Analyze"},
      {cifti, "CIFTI"},
      {nifti(2).substr(0, 200), "ends within its header"},
      {nifti(64).substr(0, 4000), "cut short"},
      {nrrd("block", raw + "\n"), "type 'block'"},
      {nrrd("uchar", "encoding: bzip2\n\n"), "'bzip2'"},
      {nrrd("uchar", "\n") + uchar, "its header has no 'encoding'"},
      {"NRRD0004\ntype: uchar\n" + raw + "\n" + uchar, "its header has no 'sizes'"},
      {nrrd("short", raw + "\n") + uchar + uchar, "byte order"},
      {nrrd("uchar", raw + "data file: LIST\na.raw\n"), "several files"},
      {nrrd("uchar", raw + "data file: s%03d.raw 1 3 1\n"), "several files"},
      {nrrd("uchar", raw + "data file: ../a.raw\n"), "header's folder"},
      {nrrd("uchar", raw + "data file: /etc/passwd\n"), "header's folder"},
      {nrrd("uchar", "encoding: ascii\n\n1 2 x") + std::string(4000, ' '), "'x'"},
      {nrrd("uchar", raw + "\n") + "short", "cut short"},
      {nrrd("uchar", raw + "line skip: 9223372036854775807\n\n") + uchar, "cut short"},
      {nrrd("uchar", "encoding: text\nbyte skip: 9223372036854775807\n\n") + uchar, "cut short"},
      {nrrd("uchar", raw + "byte skip: -1\n\n") + uchar.substr(1), "cut short"},
      {nrrd("uchar", raw + "byte skip: -2\n\n") + uchar, "below 0"},
      {nifti_header(false, false, 2, {1, 1, 1, 32767, 1, 3}) + std::string(3 * 32767, '\1'),
       "98301 frames"},
      {nrrd("uchar", "encoding: gzip\n\n") + packed.substr(0, packed.size() / 2), "too early"},
      {nrrd("uchar", "encoding: gzip\n\n") + packed.substr(0, packed.size() - 8), "too early"},
      {nrrd("uchar", "encoding: gzip\n\n") + wrong_sum, "damaged"},
  };
  for (const auto& [bytes, what] : all) {
    const auto path = test::write_bytes("refused.nrrd", bytes);
    const std::string message = refusal_of(path);
    EXPECT_TRUE(has(message, what));
    EXPECT_EQ(message.find(path.string() + ":"), 0u) << message;
  }
}

/// Files that lie, one each for a number: numbers of the header changed, or the file cut.
void expect_no_crash(const std::string& good, std::size_t header) {
  ASSERT_EQ(refusal_of(test::write_bytes("good.nrrd", good)), "");
  int refused = 0;
  for (unsigned number = 0; number < 200; ++number) {
    std::mt19937 random(number);
    std::string bytes = good;
    if (number % 4 == 0) bytes.resize(random() % bytes.size());
    for (unsigned n = number % 5; n > 0 && !bytes.empty(); --n) {
      const std::size_t at = random() % std::min(header, bytes.size());
      constexpr char extremes[] = {0, 1, 9, '9', '-', 127, -128, -1, ' ', '\n'};
      bytes[at] = random() % 2 ? extremes[random() % sizeof extremes] : char(random());
    }
    SCOPED_TRACE(number);
    refused += !refusal_of(test::write_bytes("lie.nrrd", bytes)).empty();
  }
  EXPECT_GT(refused, 50);  // the cut ones
  EXPECT_LT(refused, 200);
}

TEST(Scans, LiesAreRefusedOrRead) {
  const std::string values = values_of_type<std::int16_t>(false, 1, false, 2);
  const std::string first = nifti_header(false, false, 4, dims({2})) + values;
  expect_no_crash(first, 352);
  expect_no_crash(nifti_header(true, true, 4, dims({2})) + values, 544);
  expect_no_crash(gzipped(first), 400);
  const std::string head = nrrd("short", "endian: little\nencoding: ");
  expect_no_crash(head + "raw\n\n" + values, head.size() + 5);
  expect_no_crash(head + "gzip\n\n" + gzipped(values), head.size() + 60);
  std::string text;
  for (int i = 0; i < 990; ++i) text += std::to_string(i) + " ";
  expect_no_crash(head + "text\n\n" + text, head.size() + 100);
}

TEST(Scans, AClaimOfManyValuesTakesNoMemory) {
  // 32767^3 values of 8 bytes, in a small gzip and in a small file
  const std::string head = nifti_header(false, false, 64, {32767, 32767, 32767});
  for (const std::string& bytes : {head + std::string(9000, '\0'), gzipped(head)})
    EXPECT_TRUE(has(refusal_of(test::write_bytes("huge.nii", bytes)), "cut short"));
}

}  // namespace
}  // namespace psivox::test
