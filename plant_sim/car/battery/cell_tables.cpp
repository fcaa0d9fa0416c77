// SPDX-License-Identifier: Apache-2.0
#include "car/battery/cell_tables.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "car/battery/cell_effects.hpp"
#include "car/battery/parameter_map.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kLeastResistance = 1e-9;  // ohm; effects may take away, never turn a resistance round

double polynomial(const std::vector<double>& coefficients, double x) {
  double sum = 0.0;
  for (std::size_t i = coefficients.size(); i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

double piecewise(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, at);
  const auto i = static_cast<std::size_t>(above - x.begin());
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

}  // namespace

CellTables::Axis::Place CellTables::Axis::find(double x) const {
  if (at.size() == 1 || x <= at.front()) return {0, 0.0};
  if (x >= at.back()) return {at.size() - 2, 1.0};
  std::size_t i = 0;
  while (x >= at[i + 1]) ++i;  // a handful of breakpoints: a walk beats a bisection
  return {i, (x - at[i]) / (at[i + 1] - at[i])};
}

CellTables::CellTables(const CellParameters& cell)
    : branches_(std::max<std::size_t>(1, cell.branch_count())),
      effects_(cell.effects),
      reference_temperature_c_(cell.reference_temperature_c) {
  require_increasing(cell, "breakpoints.soc", cell.soc_breakpoints);
  require_increasing(cell, "breakpoints.temperature_c", cell.temperature_breakpoints_c);
  require_increasing(cell, "breakpoints.current_a", cell.current_breakpoints_a);
  soc_.at = cell.soc_breakpoints;
  temperature_.at = cell.temperature_breakpoints_c;
  current_.at = cell.current_breakpoints_a;

  std::vector<std::vector<double>> tables{expand(cell, "r0", cell.r0_ohm)};
  for (std::size_t k = 0; k < branches_; ++k)
    tables.push_back(expand(cell, fmt::format("r{}", k + 1), cell.branches[k].r_ohm));
  for (std::size_t k = 0; k < branches_; ++k)
    tables.push_back(expand(cell, fmt::format("tau{}", k + 1), cell.branches[k].tau_s));
  for (std::size_t n = 0; n < tables[0].size(); ++n) {
    for (const std::vector<double>& table : tables) nodes_.push_back(table[n]);
  }

  if (cell.kinetic_law || effects_.exchange_current_change != 0.0) {
    const bool known = cell.r0_ohm.exchange_current_a > 0.0;
    for (std::size_t t = 0; t < temperature_.at.size(); ++t)
      log_exchange_.push_back(
          std::log(known ? exchange_current_of(cell, temperature_.at[t]) : exchange_current(t)));
  }
  if (cell.kinetic_law) {
    refine_over_temperature();
    refine_over_current();
  }
  if (effects_.exchange_current_change == 0.0) log_exchange_.clear();
  const bool tabulated = !cell.ocv_soc.empty();
  if (tabulated) require_increasing(cell, "ocv.soc", cell.ocv_soc);
  if (tabulated && (cell.ocv_soc.size() < 2 || cell.ocv_v.size() != cell.ocv_soc.size())) {
    throw InputError(place_in(cell, "ocv"),
                     fmt::format("{} values of soc and {} of voltage_v", cell.ocv_soc.size(), cell.ocv_v.size()),
                     "two or more of each, as many", "Complete the curve");
  }
  if (!tabulated && cell.ocv_polynomial_v.empty()) {
    throw InputError(place_in(cell, "ocv"), "no open-circuit voltage",
                     "ocv.polynomial_v, or ocv.soc with ocv.voltage_v",
                     "Add one of the two");
  }
  const std::vector<double>& change = cell.effects.ocv_change_v;
  std::vector<double> change_soc;
  for (std::size_t i = 0; i < change.size(); ++i) {
    change_soc.push_back(static_cast<double>(i) / static_cast<double>(change.size() - 1));
  }
  if (change.size() == 1) {
    throw InputError(place_in(cell, "effects.ocv_change_v"), "one value", "two or more, from SOC 0 to 1",
                     "Add values, or leave the key out");
  }
  ocv_.resize(kOcvIntervals + 1);
  for (std::size_t i = 0; i <= kOcvIntervals; ++i) {
    const double soc = static_cast<double>(i) / kOcvIntervals;
    ocv_[i] = tabulated ? piecewise(cell.ocv_soc, cell.ocv_v, soc) : polynomial(cell.ocv_polynomial_v, soc);
    constexpr double kRounding = 1e-9;  // V; a level curve may lose a last bit between two equal points
    if (!change.empty()) {
      ocv_[i] += piecewise(change_soc, change, soc);
      if (i > 0) ocv_[i] = std::max(ocv_[i], ocv_[i - 1]);  // a change levels the curve, it never turns it down
    }
    if (i > 0 && ocv_[i] < ocv_[i - 1] - kRounding) {
      throw InputError(
          place_in(cell, tabulated ? "ocv.voltage_v" : "ocv.polynomial_v"),
          fmt::format("a voltage that falls from {:.4f} to {:.4f} V at SOC {:.3f}", ocv_[i - 1], ocv_[i], soc),
          "one that does not fall as SOC rises", "Correct the curve");
    }
  }
}

double CellTables::exchange_current(std::size_t temperature) const {
  const std::size_t nc = current_.at.size(), nt = temperature_.at.size(), ns = soc_.at.size();
  const double at_c = temperature_.at[temperature];
  std::vector<double> r0(nc, 0.0);
  double r1 = 0.0;
  for (std::size_t s = 0; s < ns; ++s) {
    for (std::size_t c = 0; c < nc; ++c) {
      const double* at = node((s * nt + temperature) * nc + c);
      r0[c] += at[0] / static_cast<double>(ns);
      r1 += at[1] / static_cast<double>(ns * nc);
    }
  }
  // A resistance without a current says nothing of how it bends.
  const auto first = static_cast<std::size_t>(
      std::find_if(current_.at.begin(), current_.at.end(), [](double a) { return a > 0.0; }) - current_.at.begin());
  if (first + 1 >= nc) return 2.0 * kGasConstant * (at_c + kZeroCelsius) / (kFaraday * r1);
  // R0(I) = ohms + v_ct(I) / I: the ohms are the mean of what is left, the exchange current is looked for.
  constexpr int kTried = 120;
  constexpr double kLeast = 0.02, kMost = 5.0;  // of the largest current
  double best = 1e300, out = 0.0;
  for (int k = 0; k <= kTried; ++k) {
    const double tried = current_.at.back() * kLeast * std::pow(kMost / kLeast, static_cast<double>(k) / kTried);
    std::vector<double> rest(nc);
    double ohms = 0.0, square = 0.0;
    for (std::size_t c = first; c < nc; ++c) {
      rest[c] = r0[c] - charge_transfer_v(tried, current_.at[c], at_c) / current_.at[c];
      ohms += rest[c] / static_cast<double>(nc - first);
    }
    for (std::size_t c = first; c < nc; ++c) square += std::pow(rest[c] - std::max(0.0, ohms), 2);
    if (square >= best) continue;
    best = square;
    out = tried;
  }
  return out;
}

namespace {

/// A parameter at a share of the way from one temperature to the next on the scale of 1/T. One that changes by more
/// than kinetics do is straight between them, and held beyond.
double by_arrhenius(double low, double high, double fraction) {
  constexpr double kMost = 5.0;  // between neighbours; 60 kJ/mol over 15 K is 3.2
  const double ratio = high / low;
  if (ratio > kMost || ratio < 1.0 / kMost) return low + (high - low) * std::clamp(fraction, 0.0, 1.0);
  return low * std::pow(ratio, fraction);
}

/// The branches' R at a share of the way. How a lag is divided among branches follows no kinetics; their sum does.
void branches_by_arrhenius(const double* low, const double* high, double fraction, std::size_t count, double* out) {
  const double all_low = std::accumulate(low + 1, low + count, low[0]),
               all_high = std::accumulate(high + 1, high + count, high[0]),
               sum = by_arrhenius(all_low, all_high, fraction);
  double left = 1.0;
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const double share_low = low[k] / all_low, share_high = high[k] / all_high;
    const double share = share_low + (share_high - share_low) * std::clamp(fraction, 0.0, 1.0);
    out[k] = std::max(share * sum, kLeastResistance);
    left -= share;
  }
  out[count - 1] = std::max(left * sum, kLeastResistance);
}

}  // namespace

void CellTables::refine_over_temperature() {
  constexpr double kStep = 2.0, kBeyond = 10.0;  // K; over 2 K a straight line is within 0.1 % of Arrhenius
  const std::vector<double> known = temperature_.at;
  if (known.size() < 2) return;
  const std::size_t nc = current_.at.size(), ns = soc_.at.size();
  const auto parts = static_cast<std::size_t>(std::ceil((known.back() - known.front() + 2.0 * kBeyond) / kStep));
  std::vector<double> at;
  for (std::size_t k = 0; k <= parts; ++k) {
    at.push_back(known.front() - kBeyond + (known.back() - known.front() + 2.0 * kBeyond) * static_cast<double>(k) /
                                               static_cast<double>(parts));
  }
  at.insert(at.end(), known.begin(), known.end());
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [](double a, double b) { return b - a < 1e-6; }), at.end());
  // Which known points a temperature lies between, and where between them on the scale of 1/T.
  std::vector<Axis::Place> places;
  for (const double c : at) {
    const auto above = std::upper_bound(known.begin() + 1, known.end() - 1, c);
    const auto high = static_cast<std::size_t>(above - known.begin());
    const auto inverse = [](double celsius) { return 1.0 / (celsius + kZeroCelsius); };
    const double from = inverse(known[high - 1]);
    places.push_back({high - 1, (inverse(c) - from) / (inverse(known[high]) - from)});
  }
  std::vector<double> fine(ns * at.size() * nc * width());
  for (std::size_t s = 0; s < ns; ++s) {
    for (std::size_t t = 0; t < at.size(); ++t) {
      for (std::size_t c = 0; c < nc; ++c) {
        const double* low = node((s * known.size() + places[t].index) * nc + c);
        const double* high = node((s * known.size() + places[t].index + 1) * nc + c);
        double* out = &fine[((s * at.size() + t) * nc + c) * width()];
        const double fraction = places[t].fraction;
        out[0] = by_arrhenius(low[0], high[0], fraction);
        branches_by_arrhenius(low + 1, high + 1, fraction, branches_, out + 1);
        for (std::size_t p = branches_ + 1; p < width(); ++p) out[p] = by_arrhenius(low[p], high[p], fraction);
      }
    }
  }
  std::vector<double> exchange;
  for (const Axis::Place& place : places) {
    exchange.push_back(log_exchange_[place.index] +
                       place.fraction * (log_exchange_[place.index + 1] - log_exchange_[place.index]));
  }
  nodes_ = std::move(fine);
  log_exchange_ = std::move(exchange);
  temperature_.at = std::move(at);
}

void CellTables::refine_over_current() {
  constexpr std::size_t kParts = 6, kBelow = 2, kAbove = 3;
  constexpr double kBeyond = 1.5;  // of the largest current
  constexpr double kLeast = 0.2;   // of R0 at the nearest breakpoint
  const std::vector<double> known = current_.at;
  if (known.size() < 2 || !(known.front() > 0.0)) return;
  std::vector<double> at;
  const auto between = [&](double low, double high, std::size_t parts) {
    for (std::size_t k = 0; k < parts; ++k) {
      at.push_back(low + (high - low) * static_cast<double>(k) / static_cast<double>(parts));
    }
  };
  between(0.0, known.front(), kBelow);
  for (std::size_t c = 1; c < known.size(); ++c) between(known[c - 1], known[c], kParts);
  between(known.back(), kBeyond * known.back(), kAbove);
  at.push_back(kBeyond * known.back());
  const std::size_t nt = temperature_.at.size(), ns = soc_.at.size();
  Axis coarse{known};
  std::vector<double> fine(ns * nt * at.size() * width());
  for (std::size_t t = 0; t < nt; ++t) {
    const auto bend = [&](double current) {
      const double least = std::max(current, 1e-3 * known.front());
      return charge_transfer_v(std::exp(log_exchange_[t]), least, temperature_.at[t]) / least;
    };
    for (std::size_t s = 0; s < ns; ++s) {
      for (std::size_t c = 0; c < at.size(); ++c) {
        const Axis::Place place = coarse.find(at[c]);
        const double* below = node((s * nt + t) * known.size() + place.index);
        const double* above = below + width();
        double* out = &fine[((s * nt + t) * at.size() + c) * width()];
        for (std::size_t p = 0; p < width(); ++p) out[p] = below[p] + place.fraction * (above[p] - below[p]);
        const double low = bend(known[place.index]), high = bend(known[place.index + 1]);
        const double added = bend(at[c]) - (low + place.fraction * (high - low));
        out[0] = std::max(out[0] + added, kLeast * out[0]);
      }
    }
  }
  nodes_ = std::move(fine);
  current_.at = std::move(at);
}

template <std::size_t N>
CircuitOf<N> CellTables::circuit_of(double soc, double temperature_c, double current_a) const {
  constexpr std::size_t kWidth = 2 * N + 1;
  const auto s = soc_.find(soc);
  const auto t = temperature_.find(temperature_c);
  const auto c = current_.find(current_a);
  const std::size_t nc = current_.at.size();
  const std::size_t nt = temperature_.at.size();
  const std::size_t step_s = soc_.at.size() > 1 ? nt * nc : 0;
  const std::size_t step_t = nt > 1 ? nc : 0;
  const std::size_t step_c = nc > 1 ? 1 : 0;
  const std::size_t base = (s.index * nt + t.index) * nc + c.index;
  std::array<double, kWidth> sum{};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const bool up_s = (corner & 4U) != 0;
    const bool up_t = (corner & 2U) != 0;
    const bool up_c = (corner & 1U) != 0;
    const double weight = (up_s ? s.fraction : 1.0 - s.fraction) * (up_t ? t.fraction : 1.0 - t.fraction) *
                          (up_c ? c.fraction : 1.0 - c.fraction);
    const double* at = &nodes_[(base + (up_s ? step_s : 0) + (up_t ? step_t : 0) + (up_c ? step_c : 0)) * kWidth];
    for_each_branch<kWidth>([&](auto p) { sum[p] += weight * at[p]; });
  }
  const double factor = resistance_factor(effects_, soc, temperature_c, reference_temperature_c_);
  double exchange = 0.0;
  if (!log_exchange_.empty()) {
    const double up = nt > 1 ? log_exchange_[t.index + 1] : log_exchange_[t.index];
    exchange = std::exp(log_exchange_[t.index] + t.fraction * (up - log_exchange_[t.index]));
  }
  const double r0 = sum[0] * factor + effects_.series_ohm +
                    (log_exchange_.empty() ? 0.0
                                           : charge_transfer_change(effects_, exchange, current_a, temperature_c));
  CircuitOf<N> out;
  out.r0_ohm = std::max(r0, kLeastResistance);
  for_each_branch<N>([&](auto k) {
    out.r_ohm[k] = sum[1 + k] * factor;
    out.tau_s[k] = sum[1 + N + k];
  });
  return out;
}

template CircuitOf<1> CellTables::circuit_of<1>(double, double, double) const;
template CircuitOf<2> CellTables::circuit_of<2>(double, double, double) const;
template CircuitOf<3> CellTables::circuit_of<3>(double, double, double) const;
template CircuitOf<4> CellTables::circuit_of<4>(double, double, double) const;

CircuitParameters CellTables::circuit(double soc, double temperature_c, double current_a) const {
  return with_branches(branches_, [&](auto n) {
    const auto known = circuit_of<n>(soc, temperature_c, current_a);
    CircuitParameters out{};
    out.r0_ohm = known.r0_ohm;
    std::copy(known.r_ohm.begin(), known.r_ohm.end(), out.r_ohm.begin());
    std::copy(known.tau_s.begin(), known.tau_s.end(), out.tau_s.begin());
    return out;
  });
}

OcvPoint CellTables::ocv(double soc) const {
  const double place = soc * kOcvIntervals;
  const auto i = static_cast<std::size_t>(std::clamp(place, 0.0, kOcvIntervals - 1.0));
  const double rise = ocv_[i + 1] - ocv_[i];
  return {ocv_[i] + rise * (place - static_cast<double>(i)), rise * kOcvIntervals};
}

double CellTables::ocv_v(double soc, double temperature_c) const {
  return ocv(soc).voltage_v + reversible_voltage(effects_, temperature_c, reference_temperature_c_);
}

double CellTables::soc_of_ocv(double voltage_v, double temperature_c) const {
  voltage_v -= reversible_voltage(effects_, temperature_c, reference_temperature_c_);
  if (voltage_v <= ocv_.front()) return 0.0;
  if (voltage_v >= ocv_.back()) return 1.0;
  const auto above = std::upper_bound(ocv_.begin(), ocv_.end(), voltage_v);
  const auto i = static_cast<std::size_t>(above - ocv_.begin());
  const double fraction = (voltage_v - ocv_[i - 1]) / (ocv_[i] - ocv_[i - 1]);
  return (static_cast<double>(i - 1) + fraction) / kOcvIntervals;
}

}  // namespace voltlap::plant
