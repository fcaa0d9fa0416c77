// SPDX-License-Identifier: Apache-2.0
#include "machine.hpp"

#include <fstream>
#include <thread>

namespace voltlap::benchmarks {
namespace {

constexpr const char* kUnknown = "unknown";

std::string first_line(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  return std::getline(in, line) && !line.empty() ? line : kUnknown;
}

/// A field of /proc/cpuinfo, of the first core.
std::string cpu_field(const std::string& name) {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with(name) && colon != std::string::npos) return line.substr(colon + 2);
  }
  return kUnknown;
}

}  // namespace

Machine this_machine() {
  const std::string mhz = cpu_field("cpu MHz");  // of this moment
  return {.cpu = cpu_field("model name"),
          .cores = static_cast<int>(std::thread::hardware_concurrency()),
          .governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
          .frequency = mhz == kUnknown ? mhz : mhz.substr(0, mhz.find('.')) + " MHz",
          .compiler = VOLTLAP_COMPILER,
          .build_type = VOLTLAP_BUILD_TYPE,
          .flags = VOLTLAP_FLAGS,
          .version = VOLTLAP_VERSION};
}

}  // namespace voltlap::benchmarks
