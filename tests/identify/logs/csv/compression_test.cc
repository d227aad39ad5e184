// Logs that gzip and zstd packed: what zlib and libzstd pack is read as if it had never been packed,
// and what is cut, damaged or a bomb is refused with how far it could be read.
#include "identify/logs/csv/compression.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <ostream>
#include <string>

#include "identify/logs/log.h"
#include "model/core/errors.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::WriteText;

std::string Gzip(const std::string& text) {
  z_stream stream{};
  constexpr int kAsGzip = 16;
  EXPECT_EQ(
      deflateInit2(
          &stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kAsGzip + MAX_WBITS, 8, Z_DEFAULT_STRATEGY),
      Z_OK);
  std::string packed(deflateBound(&stream, text.size()) + 64, '\0');
  std::string input = text;
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  const std::size_t size = stream.total_out;
  deflateEnd(&stream);
  return packed.substr(0, size);
}

std::string Zstd(const std::string& text) {
  std::string packed(ZSTD_compressBound(text.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 3);
  EXPECT_EQ(ZSTD_isError(size), 0U);
  packed.resize(size);
  return packed;
}

// Enough rows for several pieces of text, with the given one spoiled.
std::string Rows(std::size_t rows, std::size_t spoiled = 0) {
  std::string text = "time_s,current_A,voltage_V\n0,0,4.1\n";
  for (std::size_t k = 1; k < rows; ++k) {
    fmt::format_to(std::back_inserter(text),
                   "{},{},{:.6f}\n",
                   k,
                   k == spoiled ? "x" : "2.5",
                   4.0 - 1e-6 * static_cast<double>(k) - 1e-7 * static_cast<double>(k * 7919 % 97));
  }
  return text;
}

std::string Refusal(const std::string& bytes) {
  const std::string file = WriteText("log.csv", bytes);
  std::string message = test::LoadErrorOf([&] { (void)ReadLog(file); });
  if (message.starts_with(file)) message = "F" + message.substr(file.size());
  return message;
}

struct Packer {
  const char* name;
  std::string (*pack)(const std::string& text);
};

void PrintTo(const Packer& packer, std::ostream* stream) { *stream << packer.name; }

class EachPacker : public testing::TestWithParam<Packer> {};

TEST_P(EachPacker, LogIsReadAsIfItHadNeverBeenPacked) {
  const std::string text = Rows(200000);
  const Log plain = ReadLogText(text, "F");
  const Log log = ReadLogText(GetParam().pack(text), "F");
  EXPECT_EQ(log.record.time_s, plain.record.time_s);
  EXPECT_EQ(log.record.current_A, plain.record.current_A);
  EXPECT_EQ(log.record.voltage_V, plain.record.voltage_V);
  ASSERT_EQ(log.report.notes.size(), plain.report.notes.size() + 1);
  EXPECT_EQ(log.report.notes[0], std::string("unpacked by ") + GetParam().name);
}

TEST_P(EachPacker, StreamsThatFollowOneAnotherAreOneLog) {
  const std::string text = Rows(50000);
  const auto half = text.size() / 2;
  const std::string packed =
      GetParam().pack(text.substr(0, half)) + GetParam().pack(text.substr(half));
  EXPECT_EQ(ReadLogText(packed, "F").record.voltage_V, ReadLogText(text, "F").record.voltage_V);
}

TEST_P(EachPacker, ErrorsNameTheLineOfTheText) {
  EXPECT_EQ(Refusal(GetParam().pack(Rows(100000, 70000))),
            "F:70002:7: error: expected a number in column 'current_A', found 'x'");
}

TEST_P(EachPacker, AFileThatIsCutSaysHowFarItGoes) {
  std::string packed = GetParam().pack(Rows(100000));
  packed.resize(packed.size() / 2);
  const std::string message = Refusal(packed);
  EXPECT_TRUE(message.starts_with(fmt::format(
      "F:1:1: error: expected {} to its end, found the end of the file before that ({} bytes into "
      "the file); what comes before stands for ",
      GetParam().name,
      packed.size())))
      << message;
  EXPECT_TRUE(message.ends_with(" bytes: unpack what can be unpacked, and read that")) << message;
}

TEST_P(EachPacker, ADamagedFileIsRefused) {
  std::string packed = GetParam().pack(Rows(100000));
  for (std::size_t k = packed.size() / 2; k < packed.size() / 2 + 40; ++k) packed[k] ^= 0x55;
  // Wrong text may be seen before the sum that does not fit.
  EXPECT_TRUE(Refusal(packed).starts_with("F:"));
}

TEST_P(EachPacker, NothingPackedIsNoLog) {
  EXPECT_EQ(Refusal(GetParam().pack("")),
            fmt::format("F:1:1: error: expected a log, found an empty file packed by {}",
                        GetParam().name));
}

// Rows that repeat get a thousand times shorter: no log does.
TEST_P(EachPacker, ABombIsRefused) {
  std::string text = "time_s,current_A,voltage_V\n";
  while (text.size() < Decompressor::kMostFree + (std::size_t{3} << 24)) text += "0,0,4.1000000\n";
  const std::string message = Refusal(GetParam().pack(text));
  EXPECT_TRUE(message.starts_with("F:1:1: error: expected a log, found ")) << message;
  EXPECT_TRUE(message.ends_with(" bytes and more: no log gets 100 times shorter")) << message;
}

TEST_P(EachPacker, WhatIsPackedTwiceIsRefused) {
  EXPECT_EQ(Refusal(GetParam().pack(GetParam().pack(Rows(10)))),
            fmt::format("F:1:1: error: expected a log as text, found a {} file; unpack it and name "
                        "the log inside",
                        GetParam().name));
}

INSTANTIATE_TEST_SUITE_P(Compression,
                         EachPacker,
                         testing::Values(Packer{"gzip", &Gzip}, Packer{"zstd", &Zstd}),
                         [](const auto& packer) { return std::string(packer.param.name); });

// Packed by other programs: Python's gzip, and a frame of zstd by its specification.
TEST(Packed, FixturesAreTheFixtureThatTheyWereMadeFrom) {
  const std::string folder = test::SourcePath("fixtures/logs/");
  const Log plain = ReadLog(folder + "plain-csv/si.csv");
  for (const char* name : {"packed/si.csv.gz", "packed/si.csv.zst"}) {
    SCOPED_TRACE(name);
    const Log log = ReadLog(folder + name);
    EXPECT_EQ(log.record.time_s, plain.record.time_s);
    EXPECT_EQ(log.record.current_A, plain.record.current_A);
    EXPECT_EQ(log.record.voltage_V, plain.record.voltage_V);
  }
}

// As pzstd writes it: a frame to be skipped, with the size of the one that follows, comes first.
TEST(Zstd, AFrameToBeSkippedMayComeFirst) {
  const std::string text = Rows(1000);
  const std::string skipped("\x50\x2A\x4D\x18\x04\x00\x00\x00\x01\x02\x03\x04", 12);
  const Log log = ReadLog(WriteText("log.csv", skipped + Zstd(text)));
  EXPECT_EQ(log.record.time_s, ReadLog(WriteText("plain.csv", text)).record.time_s);
}

TEST(Gzip, AWrongSumIsSaid) {
  std::string packed = Gzip(Rows(1000));
  packed[packed.size() - 6] ^= 1;
  EXPECT_EQ(
      Refusal(packed),
      fmt::format("F:1:1: error: expected gzip to its end, found incorrect data check ({} bytes "
                  "into the file); what comes before stands for {} bytes: unpack what can be "
                  "unpacked, and read that",
                  packed.size() - 4,
                  Rows(1000).size()));
}

TEST(Gzip, ZerosBehindTheEndAreNothing) {
  const std::string text = Rows(1000);
  EXPECT_EQ(ReadLogText(Gzip(text) + std::string(1000, '\0'), "F").record.size(), 1000U);
  EXPECT_EQ(Refusal(Gzip(text) + "more").substr(0, 80),
            "F:1:1: error: expected gzip to its end, found bytes that are none behind its end");
}

}  // namespace
}  // namespace lipoid
