// SPDX-License-Identifier: Apache-2.0
#include "quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voltlap::benchmarks {

std::string time_text(double ns) {
  const char* units[] = {"ns", "us", "ms", "s"};
  std::size_t unit = 0;
  while (ns >= 999.5 && unit < 3) {
    ns /= 1000.0;
    ++unit;
  }
  const int digits = ns < 9.995 ? 2 : ns < 99.95 ? 1 : 0;
  return fmt::format("{:.{}f} {}", ns, digits, units[unit]);
}

std::string factor_text(double factor) {
  if (factor < 9.995) return fmt::format("{:.2f}", factor);
  const double step = std::pow(10.0, std::max(0.0, std::floor(std::log10(factor)) - 3.0));  // four digits
  std::string text = fmt::format("{:.0f}", std::round(factor / step) * step);
  for (std::size_t digits = text.size(); digits > 3; digits -= 3) text.insert(digits - 3, 1, ' ');
  return text;
}

}  // namespace voltlap::benchmarks
