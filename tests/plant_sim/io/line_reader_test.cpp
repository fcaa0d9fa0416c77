// SPDX-License-Identifier: Apache-2.0
#include "io/line_reader.hpp"

#include <zlib.h>
#include <zstd.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <vector>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(LineReader) {
  Scratch scratch;
  std::vector<std::string> lines_of(const std::string& path, BrokenStream broken = BrokenStream::kRefuse) {
    LineReader reader(path, "a file", broken);
    std::vector<std::string> out;
    std::string_view line;
    while (reader.next(line)) out.emplace_back(line);
    LONGS_EQUAL(out.size(), reader.number());
    return out;
  }
  std::string binary(const char* name, const std::string& bytes) {
    std::ofstream(scratch.file(name), std::ios::binary) << bytes;
    return scratch.file(name);
  }
  static std::string gzip(const std::string& text) {
    z_stream state{};
    deflateInit2(&state, 6, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY);
    std::string out(text.size() + 1000, '\0');
    state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    state.avail_in = static_cast<uInt>(text.size());
    state.next_out = reinterpret_cast<Bytef*>(out.data());
    state.avail_out = static_cast<uInt>(out.size());
    deflate(&state, Z_FINISH);
    out.resize(state.total_out);
    deflateEnd(&state);
    return out;
  }
  static std::string zstd(const std::string& text) {
    std::string out(ZSTD_compressBound(text.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3));
    return out;
  }
};

TEST(LineReader, EveryEndOfLineInEveryWrappingGivesTheSameLines) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given != nullptr ? static_cast<unsigned>(std::atoi(given)) : std::random_device{}();
  std::mt19937 random(seed);
  for (int k = 0; k < 20; ++k) {
    // Lengths around the buffer's, so that ends of lines fall on its end; many and few lines.
    std::vector<std::string> lines;
    const std::size_t longest = k % 2 == 0 ? 60 : 100000;
    std::size_t left = 900000;
    while (left > 0) {
      const std::size_t length = std::min<std::size_t>(left, random() % longest);
      lines.emplace_back(length, static_cast<char>('a' + random() % 26));
      left -= std::min(left, length + 1);
    }
    lines.emplace_back("end");
    for (const char* end : {"\n", "\r\n", "\r"}) {
      std::string text;
      for (const std::string& line : lines) text += line + end;
      if (k % 3 == 0) text.resize(text.size() - std::string(end).size());
      for (const std::string& bytes : {text, gzip(text), zstd(text)}) {
        const auto read = lines_of(binary("a", bytes));
        CHECK_TEXT(read == lines, StringFromFormat("VOLTLAP_TEST_SEED=%u, draw %d", seed, k).asCharString());
      }
    }
  }
}

TEST(LineReader, MembersOneAfterTheOtherAreOneFile) {
  CHECK(lines_of(binary("a.gz", gzip("1\n2\n") + gzip("3\n"))) == (std::vector<std::string>{"1", "2", "3"}));
  CHECK(lines_of(binary("a.zst", zstd("1\n2\n") + zstd("3\n"))) == (std::vector<std::string>{"1", "2", "3"}));
}

TEST(LineReader, AStreamThatBreaksOffIsRefusedOrKeptUpToThere) {
  std::string text;
  std::mt19937 random(1);
  for (int k = 0; k < 20000; ++k) text += std::to_string(random()) + "\n";
  for (std::string bytes : {gzip(text), zstd(text)}) {
    bytes.resize(bytes.size() * 2 / 3);
    const std::string path = binary("cut", bytes);
    STRCMP_CONTAINS("breaks off", complaint([&] { lines_of(path); }).c_str());
    const auto kept = lines_of(path, BrokenStream::kKeep);
    CHECK(kept.size() > 5000);
    STRNCMP_EQUAL(kept.back().c_str(), text.c_str() + text.find("\n" + kept.back() + "\n") + 1, kept.back().size());
  }
  std::string damaged = gzip(text);
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x55);
  STRCMP_CONTAINS("compressed stream", complaint([&] { lines_of(binary("bad", damaged)); }).c_str());
}

TEST(LineReader, EmptyFilesHaveNoLinesAndEmptyLinesCount) {
  CHECK(lines_of(binary("a", "")).empty());
  CHECK(lines_of(binary("a", gzip(""))).empty());
  CHECK(lines_of(binary("a", "\n\r\n\r")) == (std::vector<std::string>{"", "", ""}));
  STRCMP_CONTAINS("beyond 1 MB", complaint([&] { lines_of(binary("a", std::string(3000000, 'x'))); }).c_str());
}
