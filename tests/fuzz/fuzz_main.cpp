// SPDX-License-Identifier: Apache-2.0
// The fuzzer: libFuzzer's own flags, and --target=NAME (one of target.cpp). `--list` shows the targets. One more,
// `planted`, has a defect, so that a test can see it found.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "fuzz/trial.hpp"

namespace {

void read_with_defect(const std::string& path) {
  if (voltlap::plant::content_of(path).starts_with('A')) throw std::out_of_range("planted");
}

constexpr voltlap::plant::FuzzTarget kPlanted{"planted", "input", 16, read_with_defect};
const voltlap::plant::FuzzTarget* target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** words) {
  constexpr std::string_view kTarget = "--target=";
  for (int k = 1; k < *count; ++k) {
    const std::string_view word = (*words)[k];
    if (word == "--list") {
      for (const auto& known : voltlap::plant::targets()) {
        std::printf("%.*s %zu\n", static_cast<int>(known.name.size()), known.name.data(), known.longest);
      }
      std::exit(0);
    }
    if (word.starts_with(kTarget)) target = voltlap::plant::find_target(word.substr(kTarget.size()));
    if (word == "--target=planted") target = &kPlanted;
  }
  if (target == nullptr) {
    std::fprintf(stderr, "no target; --target=NAME with a NAME of --list\n");
    std::exit(2);
  }
  // Without a cache a DBC file is read each time.
  unsetenv("HOME");
  unsetenv("XDG_CACHE_HOME");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static voltlap::plant::Trial trial;
  const std::string wrong = trial.run(*target, {reinterpret_cast<const char*>(data), size});
  if (wrong.empty()) return 0;
  std::fprintf(stderr, "\nFINDING: %s\n", wrong.c_str());
  std::abort();
}
