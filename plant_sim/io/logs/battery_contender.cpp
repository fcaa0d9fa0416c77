// SPDX-License-Identifier: Apache-2.0
#include "io/logs/battery_contender.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {

Standing standing_of(const SignalCandidate& candidate, Quantity quantity, Meaning meaning, bool is_can) {
  const SpokenName& name = candidate.name;
  const bool told = candidate.signal->unit.has_value();
  if (told && candidate.signal->unit->quantity != quantity) return Standing::kExcluded;
  // A letter by itself may be a symbol, or one of a, b, c.
  if (name.meaning == meaning && (told || !name.is_letter)) {
    // An inverter reckons the current on its bus from its phases.
    const bool on_bus = quantity == Quantity::kCurrent && name.owner == Owner::kBus;
    if (!name.is_actual || name.is_others || on_bus) return Standing::kNotActual;
    return name.is_plain ? Standing::kPlain : Standing::kWorded;
  }
  if (told) {
    const bool silent = (name.meaning == Meaning::kNothing || name.is_letter) && name.is_actual && !name.is_others;
    return silent ? Standing::kByUnit : Standing::kNotActual;
  }
  // A bus is full of counters and codes; without a word or a unit none of them is considered.
  return (name.meaning == Meaning::kNothing || name.is_letter) && name.is_actual && !is_can ? Standing::kUnnamed
                                                                                            : Standing::kExcluded;
}

bool is_like_a_voltage(const SignalCandidate& candidate) {
  constexpr double kLargestSwing = 0.6;
  const double swing = candidate.high() - candidate.low();
  return candidate.low() > 0.0 && *candidate.voltage_unit() != '\0' && swing < kLargestSwing * candidate.middle();
}

namespace {

/// How far apart two signals are as a rule, of what the larger one reads; 1 without anything in common.
double apart(const Contender& a, const Contender& b, double share) {
  const RoleSource sa = source_in(*a.candidate->signal, a.candidate->voltage_unit());
  const RoleSource sb = source_in(*b.candidate->signal, b.candidate->voltage_unit());
  std::vector<double> distances, sizes;
  for (std::size_t k = 0; k < a.means.size(); ++k) {
    const double va = a.means[k] * sa.scale + sa.offset, vb = b.means[k] * sb.scale + sb.offset;
    if (!std::isfinite(va) || !std::isfinite(vb)) continue;
    distances.push_back(std::abs(va - vb));
    sizes.push_back(std::max(std::abs(va), std::abs(vb)));
  }
  const double size = quantile(sizes, 0.95);
  return size > 0.0 ? quantile(distances, share) / size : 1.0;
}

}  // namespace

bool is_same(const Contender& a, const Contender& b) {
  constexpr double kRounded = 5e-4;
  return apart(a, b, 0.95) < kRounded;
}

bool is_same_level(const Contender& a, const Contender& b) {
  constexpr double kErrors = 0.01;
  return apart(a, b, 0.5) < kErrors;
}

bool are_cells_alike(const Contender& a, const Contender& b) {
  const SignalCandidate &one = *a.candidate, &other = *b.candidate;
  return !one.name.pattern.empty() && one.name.pattern == other.name.pattern && one.is_cell_voltage() &&
         other.is_cell_voltage();
}

LineFit line_fit(const std::vector<double>& y, const std::vector<double>& x, const std::vector<double>* z) {
  double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  for (std::size_t k = 0; k < y.size(); ++k) {
    const double by = z == nullptr ? x[k] : x[k] * (*z)[k];
    if (!std::isfinite(by) || !std::isfinite(y[k])) continue;
    n += 1, sx += by, sy += y[k], sxx += by * by, syy += y[k] * y[k], sxy += by * y[k];
  }
  const double xx = sxx - sx * sx / n, yy = syy - sy * sy / n, xy = sxy - sx * sy / n;
  const bool flat = !(xx > 0.0 && yy > 0.0);
  return {flat ? 1.0 : std::max(0.0, 1.0 - xy * xy / (xx * yy)), static_cast<std::size_t>(n)};
}

}  // namespace voltlap::plant
