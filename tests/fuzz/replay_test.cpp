// SPDX-License-Identifier: Apache-2.0
// Every seed, every input that was once a finding (regressions/TARGET/), and every seed grown to a megabyte, given to
// its reader.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "fuzz/trial.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kGrown = 1'000'000, kGrownFrom = 1 << 14;

/// Files of a folder by name; none when it does not exist.
std::map<std::string, std::string> files_of(const std::string& folder) {
  std::map<std::string, std::string> out;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    out[entry.path().string()] = content_of(entry.path().string());
  }
  return out;
}

/// What a reader that searches or copies too often takes long for.
std::vector<std::string> grown(const std::string& seed) {
  const std::size_t half = seed.find('\n', seed.size() / 2);
  const std::string begin = seed.substr(0, half == std::string::npos ? half : half + 1);
  const std::size_t last_end = begin.find_last_of('\n', begin.size() - std::min<std::size_t>(begin.size(), 2));
  const std::string last_line = begin.substr(last_end + 1);
  std::vector<std::string> out{seed, begin, seed};
  while (out[0].size() < kGrown && !seed.empty()) out[0] += seed;
  while (out[1].size() < kGrown && !last_line.empty()) out[1] += last_line;
  if (!seed.empty()) out[2].append(kGrown, seed[seed.size() / 2]);
  return out;
}

void use_no_dbc_cache() {
  unsetenv("HOME");
  unsetenv("XDG_CACHE_HOME");
}

}  // namespace

TEST_GROUP(Replay) {
  Trial trial;
  TEST_SETUP() { use_no_dbc_cache(); }
  void replay(const FuzzTarget& target, const std::string& folder) {
    for (const auto& [file, input] : files_of(fmt::format("{}/{}", folder, target.name))) {
      const std::string wrong = trial.run(target, input);
      if (!wrong.empty()) FAIL(fmt::format("{} of {}: {}", target.name, file, wrong).c_str());
    }
  }
};

TEST(Replay, every_seed_is_read_or_refused_in_its_words) {
  for (const FuzzTarget& target : targets()) {
    const std::string folder = fmt::format("{}/{}", VOLTLAP_FUZZ_SEEDS, target.name);
    CHECK_TEXT(!files_of(folder).empty(), fmt::format("no seed in {}", folder).c_str());
    replay(target, VOLTLAP_FUZZ_SEEDS);
  }
}

TEST(Replay, what_was_once_a_finding_is_none_any_more) {
  for (const FuzzTarget& target : targets()) replay(target, VOLTLAP_SOURCE_DIR "/tests/fuzz/regressions");
}

TEST(Replay, a_megabyte_takes_two_seconds_at_most_and_fifty_times_its_size) {
  for (const FuzzTarget& target : targets()) {
    if (target.longest < kGrownFrom) continue;
    for (const auto& [file, input] : files_of(fmt::format("{}/{}", VOLTLAP_FUZZ_SEEDS, target.name))) {
      for (const std::string& large : grown(input)) {
        const std::string wrong = trial.run(target, large);
        if (!wrong.empty()) FAIL(fmt::format("{} of {}, grown: {}", target.name, file, wrong).c_str());
      }
    }
  }
}

TEST(Replay, a_defect_is_found) {
  const FuzzTarget throws{"throws", "input", 1, [](const std::string&) { throw std::logic_error("a defect"); }};
  const FuzzTarget takes_memory{"memory", "input", 1, [](const std::string&) {
                              const std::vector<char> large(std::size_t{65} << 20);
                              if (large.back() != 0) throw std::logic_error("not zero");
                            }};
  const FuzzTarget takes_long{"long", "input", 1, [](const std::string&) {
                                const std::clock_t end = std::clock() + 21 * CLOCKS_PER_SEC / 10;
                                while (std::clock() < end) {
                                }
                              }};
  STRCMP_CONTAINS("a defect", trial.run(throws, "x").c_str());
  STRCMP_CONTAINS("of memory", trial.run(takes_memory, "x").c_str());
  STRCMP_CONTAINS("took 2.1 s", trial.run(takes_long, "x").c_str());
}
