// SPDX-License-Identifier: Apache-2.0
#include "reference_kernel.hpp"

#include <array>
#include <cstdint>

namespace voltlap::benchmarks {
namespace {

constexpr int kRounds = 60'000;
constexpr std::size_t kTable = 1024;  // 8 KiB, a power of two

constexpr std::array<double, kTable> make_table() {
  std::array<double, kTable> table{};
  for (std::size_t i = 0; i < kTable; ++i) table[i] = 1.0 + static_cast<double>(i) / kTable;
  return table;
}

}  // namespace

double reference_kernel() {
  static constexpr std::array<double, kTable> kValues = make_table();
  std::uint32_t random = 12345;
  double a = 1.0, b = 0.5;
  for (int i = 0; i < kRounds; ++i) {
    random = random * 1664525U + 1013904223U;
    const double looked_up = kValues[random >> 22];
    a = 0.999 * a + looked_up * b;
    b = (random & 0x100000U) != 0 ? b * 0.5 + 0.1 : 1.0 / (a + looked_up);
  }
  return a + b;
}

}  // namespace voltlap::benchmarks
