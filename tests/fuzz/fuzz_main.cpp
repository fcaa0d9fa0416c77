// SPDX-License-Identifier: Apache-2.0
// The fuzzer: libFuzzer's own flags, and --target=NAME (one of target.cpp) before them. `--list` shows the targets.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "fuzz/trial.hpp"

namespace {

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
