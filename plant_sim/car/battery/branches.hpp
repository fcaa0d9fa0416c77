// SPDX-License-Identifier: Apache-2.0
// A cell has 1 to 4 RC branches. What goes through all cells or all rows is generated for each number and chosen once,
// before it begins: the loop over the branches is then no loop.
#pragma once
#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "core/demand.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// The parameters of a circuit of N branches at one point of (SOC, temperature, current), in ohm and seconds.
template <std::size_t N>
struct CircuitOf {
  double r0_ohm;
  std::array<double, N> r_ohm, tau_s;
};

/// Where the number is not known beforehand: branches that a cell does not have are 0.
using CircuitParameters = CircuitOf<kMostCellBranches>;

/// All that a steady current meets in the end [ohm].
template <std::size_t N>
[[nodiscard]] double total_ohm(const CircuitOf<N>& circuit) {
  double out = circuit.r0_ohm;
  for (const double r : circuit.r_ohm) out += r;
  return out;
}

/// `f` with each branch's index, a constant.
template <std::size_t N, class F>
[[gnu::always_inline]] inline void for_each_branch(const F& f) {
  [&]<std::size_t... K>(std::index_sequence<K...>) __attribute__((always_inline)) {
    (f(std::integral_constant<std::size_t, K>{}), ...);
  }(std::make_index_sequence<N>{});
}

/// `f` with the number of branches, a constant.
template <class F>
decltype(auto) with_branches(std::size_t count, const F& f) {
  static_assert(kMostCellBranches == 4);
  VOLTLAP_DEMAND(count >= 1 && count <= kMostCellBranches);
  switch (count) {
    case 1: return f(std::integral_constant<std::size_t, 1>{});
    case 2: return f(std::integral_constant<std::size_t, 2>{});
    case 3: return f(std::integral_constant<std::size_t, 3>{});
    default: return f(std::integral_constant<std::size_t, 4>{});
  }
}

}  // namespace voltlap::plant
