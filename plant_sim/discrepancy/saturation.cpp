// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/saturation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include "discrepancy/gain.hpp"
#include "discrepancy/integrity.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Rows = std::vector<bool>;

constexpr double kBeyondStep = 1.01;  // of readings that are a step apart, but for their digits

/// Standard deviation of readings at rest; 0 where there are few.
double noise_at_rest(const VectorXd& current, double largest) {
  constexpr double kRest = 0.05, kOfNormal = 1.4826;  // of the largest reading
  constexpr std::size_t kLeast = 50;
  std::vector<double> rest;
  for (const double i : current) {
    if (std::abs(i) < kRest * largest) rest.push_back(i);
  }
  if (rest.size() < kLeast) return 0.0;
  const auto half = rest.begin() + static_cast<std::ptrdiff_t>(rest.size() / 2);
  std::nth_element(rest.begin(), half, rest.end());
  const double middle = *half;
  for (double& i : rest) i = std::abs(i - middle);
  std::nth_element(rest.begin(), half, rest.end());
  return kOfNormal * *half;
}

/// Number of readings in the pile at the upper end of `values`, which fall by `step` or more; 0: there is none. `noise`:
/// of the sensor at rest.
std::size_t pile_of(const std::vector<double>& values, double step, double noise, Index rows) {
  constexpr double kNarrowest = 1e-4, kWidest = 0.03;    // of the largest reading: the noise of its sensor
  constexpr double kSigmas = 6.0;                        // or as wide as that is at rest
  constexpr double kSteps = 3.0;                         // as far as noise blurs coarse steps
  constexpr double kWider = 1.25;
  constexpr double kLeast = 20.0, kLeastShare = 0.005;   // readings; of all rows
  constexpr double kSteep = 3.0;                         // times as many as in the same width below
  if (values.empty()) return 0;
  const double most = values.front();
  const auto within = [&](double width) {
    const auto end = std::partition_point(values.begin(), values.end(), [&](double v) { return v >= most - width; });
    return static_cast<double>(end - values.begin());
  };
  // Within less than a step there is one value, and below it nothing: that is not steep.
  const double widest = std::max({kWidest * most, kSteps * kBeyondStep * step, kSigmas * noise});
  for (double width = std::max(kNarrowest * most, kBeyondStep * step);; width = std::min(widest, width * kWider)) {
    const double in = within(width), below = within(2.0 * width) - in;
    if (in >= kLeast && in >= kLeastShare * static_cast<double>(rows) && in >= kSteep * below) {
      return static_cast<std::size_t>(in);
    }
    if (width >= widest) return 0;
  }
}

/// Mean and spread of the readings around the middle of the pile; what passes through on its way stays out.
void settle(const std::vector<double>& pile, double step, Rail& out) {
  constexpr double kNear = 2.5, kOfNormal = 1.4826, kNearlyAll = 0.98;
  const double middle = pile[pile.size() / 2];
  std::vector<double> away;
  for (const double v : pile) away.push_back(std::abs(v - middle));
  const auto half = away.begin() + static_cast<std::ptrdiff_t>(away.size() / 2);
  std::nth_element(away.begin(), half, away.end());
  const auto alike = static_cast<double>(std::count(away.begin(), away.end(), 0.0));
  // Of coarse steps most readings can be one value though noise moves many to the next.
  const bool is_blurred = *half == 0.0 && alike < kNearlyAll * static_cast<double>(pile.size());
  const double reach = is_blurred ? kBeyondStep * step : kNear * kOfNormal * *half;
  double sum = 0.0, square = 0.0, count = 0.0;
  for (const double v : pile) {
    if (std::abs(v - middle) > reach) continue;
    sum += v - middle;
    square += (v - middle) * (v - middle);
    count += 1.0;
  }
  out.limit_a = middle + sum / count;
  out.noise_a = std::sqrt(square / count);
}

/// Readings of one sign, largest first.
std::vector<double> falling(const VectorXd& current, double sign) {
  std::vector<double> out;
  for (const double i : current) {
    if (sign * i > 0.0) out.push_back(sign * i);
  }
  std::sort(out.begin(), out.end(), std::greater<>());
  return out;
}

/// What resistances, lags, charge and OCV can make of an error of the voltage behind this current.
MatrixXd followers(const World& model, const Comparison& c, const BatteryResponse& battery) {
  constexpr double kFull = 5.0;  // C
  const VectorXd i = battery.current_a / (kFull * model.car.cell.capacity_ah);
  const VectorXd soc = (battery.soc.array() - 0.5).matrix();
  const VectorXd warm = ((battery.temperature_c.array() - 25.0) / 10.0).matrix();
  std::vector<VectorXd> out{VectorXd::Ones(i.size()), soc, soc.cwiseAbs2(), soc.cwiseProduct(soc.cwiseAbs2()),
                            i, i.cwiseProduct(i.cwiseAbs()), i.cwiseProduct(soc), i.cwiseProduct(warm)};
  for (const double tau : {1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0}) out.push_back(lagged(c.log.time_s, i, tau));
  MatrixXd all(i.size(), static_cast<Index>(out.size()));
  for (std::size_t k = 0; k < out.size(); ++k) all.col(static_cast<Index>(k)) = out[k];
  return all;
}

/// What least squares of these leave of an error, fitted where `use`.
VectorXd left_by(const MatrixXd& followers, const VectorXd& error, const Rows& use) {
  constexpr double kRidge = 1e-6;
  MatrixXd gram = MatrixXd::Zero(followers.cols(), followers.cols());
  VectorXd score = VectorXd::Zero(followers.cols());
  for (Index row = 0; row < error.size(); ++row) {
    if (!use[static_cast<std::size_t>(row)]) continue;
    gram.noalias() += followers.row(row).transpose() * followers.row(row);
    score += followers.row(row).transpose() * error(row);
  }
  gram.diagonal().array() += kRidge * static_cast<double>(error.size());
  return error - followers * gram.ldlt().solve(score);
}

double rms_where(const VectorXd& values, const Rows& use) {
  double square = 0.0, count = 0.0;
  for (Index row = 0; row < values.size(); ++row) {
    if (!use[static_cast<std::size_t>(row)]) continue;
    square += values(row) * values(row);
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(square / count) : 0.0;
}

Rows both(const Rows& a, const Rows& b, bool is = true) {
  Rows out(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) out[k] = a[k] && b[k] == is;
  return out;
}

/// Do the other rows know what the model makes of a large current?
bool is_shown_elsewhere(const VectorXd& current, const Rows& others, double limit_a) {
  constexpr double kLarge = 0.3, kLeast = 100.0, kLeastShare = 0.02;  // of the limit; rows; of all rows
  double rows = 0.0;
  for (Index row = 0; row < current.size(); ++row) {
    if (others[static_cast<std::size_t>(row)] && std::abs(current(row)) > kLarge * limit_a) rows += 1.0;
  }
  return rows >= kLeast && rows >= kLeastShare * static_cast<double>(current.size());
}

/// What is missing at the limit, by the voltage.
struct Missing {
  double most_a = 0.0, rows = 0.0;
  double little = 0.0;  ///< rows in which next to nothing is
  double ohm = 0.0;     ///< mean resistance to it
};

Missing missing_at(const Rows& at, const BatteryResponse& flowed, double limit_a, double ohms_per_cell) {
  constexpr double kLittle = 0.01;  // of the limit
  Missing out;
  for (Index row = 0; row < flowed.current_a.size(); ++row) {
    if (!at[static_cast<std::size_t>(row)]) continue;
    const double beyond = std::abs(flowed.current_a(row)) - limit_a;
    out.most_a = std::max(out.most_a, beyond);
    out.little += beyond < kLittle * limit_a ? 1.0 : 0.0;
    out.ohm += flowed.r0_ohm(row) * ohms_per_cell;
    out.rows += 1.0;
  }
  out.ohm /= std::max(1.0, out.rows);
  return out;
}

}  // namespace

std::optional<Rail> rail_of(const VectorXd& current) {
  constexpr double kSigmas = 8.0, kOneValue = 1e-4, kAlike = 0.02;
  Rail out;
  out.step_a = step_of(current);
  constexpr double kLeast = 0.05;  // of the largest reading: a rest that reads a step below zero is a pile too
  double largest = 0.0;
  for (const double i : current) largest = std::abs(i) > largest ? std::abs(i) : largest;
  const double noise = noise_at_rest(current, largest);
  double most = 0.0, sign = 1.0;   // readings times limit
  for (const double s : {1.0, -1.0}) {
    std::vector<double> pile = falling(current, s);
    const std::size_t n = pile_of(pile, out.step_a, noise, current.size());
    const double weight = n == 0 || pile.front() < kLeast * largest ? 0.0 : static_cast<double>(n) * pile.front();
    if (weight <= most) continue;
    most = weight;
    sign = s;
    pile.resize(n);
    settle(pile, out.step_a, out);
  }
  if (most == 0.0) return std::nullopt;
  out.from_a = out.limit_a - kSigmas * std::max(out.noise_a, kOneValue * out.limit_a);
  const std::vector<double> others = falling(current, -sign);
  const bool symmetric = !others.empty() && std::abs(others.front() - out.limit_a) < kAlike * out.limit_a;
  for (const double i : current) out.at.push_back((symmetric ? std::abs(i) : sign * i) >= out.from_a);
  return out;
}

std::optional<Saturation> saturation_of(const World& model, const Comparison& comparison) {
  constexpr double kTimes = 4.0;      // what remains of the other rows, that nothing behind the readings can follow
  constexpr double kOfLimit = 0.012;  // the same as a current
  constexpr double kAgrees = 1.1;     // times smaller is what remains of the other rows with the current that flowed
  constexpr double kMostLittle = 0.5; // of the rows
  const std::optional<Rail> rail = rail_of(*comparison.log.find("current"));
  constexpr double kFresh_s = 0.1;    // a voltage that is older says nothing of a peak
  const auto is_old = [&](const auto& age) { return age.second.maxCoeff() > kFresh_s && age.first.find("voltage") != std::string::npos; };
  if (!rail || std::any_of(comparison.log.age_s.begin(), comparison.log.age_s.end(), is_old)) return std::nullopt;
  World limited = model;
  limited.current_limit_a = rail->from_a;
  Comparison known = comparison;
  known.facts.at_limit = rail->at;
  const Prediction read = predict(model, comparison), flowed = predict(limited, known);
  const VectorXd& measured = comparison.channels.front().measured;
  const VectorXd before = measured - read.channels[0], after = measured - flowed.channels[0];
  const Rows valid = finite_rows(before), at = both(valid, rail->at), others = both(valid, rail->at, false);
  if (!is_shown_elsewhere(*comparison.log.find("current"), others, rail->limit_a)) return std::nullopt;
  const VectorXd unexplained = left_by(followers(model, comparison, read.battery), before, valid);
  const VectorXd remains = left_by(followers(model, comparison, flowed.battery), after, others);
  const double floor = rms_where(remains, others), sag = rms_where(unexplained, at);
  const double parallel = model.car.battery.cells_in_parallel, cells = std::max(1.0, comparison.facts.sensor_cells);
  const Missing missing = missing_at(at, flowed.battery, rail->limit_a / parallel, cells);
  const bool sags = sag > kTimes * floor && sag > kOfLimit * rail->limit_a / parallel * missing.ohm &&
                    missing.little < kMostLittle * missing.rows;
  const bool agrees = rms_where(unexplained, others) > kAgrees * floor;
  if (!sags || !agrees) return std::nullopt;
  Saturation out{*rail, missing.most_a * parallel, rms_where(before, others), rms_where(after, others), 0.0, 0.0};
  const double valid_rows = static_cast<double>(std::count(valid.begin(), valid.end(), true));
  const double remaining_share = 1.0 - missing.rows / valid_rows;
  out.share = std::clamp(1.0 - remaining_share * std::pow(out.after_v / rms_where(before, valid), 2), 0.0, 1.0);
  out.d_prime = sag / floor * std::sqrt(missing.rows);
  return out;
}

FoundCause found_saturation(const Saturation& s) {
  constexpr double kCertain = 0.99, kTwoSided = 1.96;
  FoundCause out;
  out.name = "current_saturation";
  // The slow part of a sensor's noise does not average out: one reading's spread is the mean's too. Readings that are all
  // alike say where it ends to half a step.
  const double half = std::max(kTwoSided * s.rail.noise_a, 0.5 * s.rail.step_a);
  out.parameters.push_back({"limit_a", "A", s.rail.limit_a, s.rail.limit_a - half, s.rail.limit_a + half, ""});
  out.share_of_residual = s.share;
  out.probability = kCertain;
  out.d_prime = s.d_prime;
  out.says = fmt::format("the current sensor ends at {:.1f} ± {:.1f} A: by the voltage, up to {:.0f} A more flowed",
                         s.rail.limit_a, std::max(0.1, half), s.most_a);
  if (s.after_v < s.before_v) {
    out.says += fmt::format("; with that, {:.3g} become {:.3g} mV of voltage error on the rows below", 1e3 * s.before_v,
                            1e3 * s.after_v);
  }
  return out;
}

void mask_rail(const Saturation& s, const Recording& log, std::vector<Masked>& masked) {
  const std::string why =
      fmt::format("it reads its limit of {:.1f} A: what flowed is told by the voltage", s.rail.limit_a);
  for (std::size_t row = 0; row < s.rail.at.size(); ++row) {
    if (!s.rail.at[row]) continue;
    std::size_t last = row;
    while (last + 1 < s.rail.at.size() && s.rail.at[last + 1]) ++last;
    masked.push_back({"current", log.time_s(static_cast<Index>(row)), log.time_s(static_cast<Index>(last)), why});
    row = last;
  }
}

void say_first(const std::string& says, std::string& sentence) {
  const std::string rest = sentence.starts_with(says) ? "" : " Besides: " + sentence;
  sentence = says + "." + rest;
  sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
}

void put_readings_before(const World& given, const Design& design, const Comparison& measured_on, Explanation& out) {
  const auto residuals = [](const World& world, const Comparison& on) { return residuals_of(on, predict(world, on)); };
  const auto was = residuals(given, measured_on), is = residuals(design.model, measured_on);
  for (std::size_t c = 0; c < was.size(); ++c) {
    const auto gain = out.gain.find(measured_on.channels[c].name);
    if (gain == out.gain.end() || !(rms_of(is[c]) > 0.0)) continue;
    const double more = rms_of(was[c]) / rms_of(is[c]);
    gain->second.before *= more;
    gain->second.drop_low = 1.0 - (1.0 - gain->second.drop_low) / more;
    gain->second.drop_high = 1.0 - (1.0 - gain->second.drop_high) / more;
  }
  const auto before = residuals(given, design.comparison);
  for (Trace& trace : out.traces) {
    for (std::size_t c = 0; c < before.size(); ++c) {
      if (!trace.member && trace.channel == design.comparison.channels[c].name) trace.before = before[c];
    }
  }
}

}  // namespace voltlap::plant
