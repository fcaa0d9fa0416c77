// SPDX-License-Identifier: Apache-2.0
#include "explain/shapes/anonymous_shapes.hpp"

#include <fmt/format.h>

#include <cmath>

#include "explain/shapes/car_shapes.hpp"
#include "explain/shapes/channel_shapes.hpp"

namespace voltlap::plant {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

/// Of the voltage: behind the current, or over the charge.
constexpr double kFast = 0.5, kSlow = 0.5, kOcv = 3.0;

/// In hours of the capacity: 1 is 1C.
VectorXd rate_of(const Shown& shown) {
  return shown.base.battery.current_a / shown.model.car.cell.capacity_ah;
}

/// Open-circuit voltage over SOC: tents every 5 %, alike over 12 %.
void ocv_shapes(const VectorXd& soc, double usual, Shapes& shapes) {
  constexpr Index kNodes = 21;
  constexpr double kAlike = 0.12;
  Eigen::MatrixXd covariance(kNodes, kNodes), tents(soc.size(), kNodes);
  for (Index k = 0; k < kNodes; ++k) {
    const double node = static_cast<double>(k) / (kNodes - 1);
    tents.col(k) = (1.0 - (soc.array() - node).abs() * (kNodes - 1)).max(0.0).matrix();
    for (Index j = 0; j < kNodes; ++j) {
      const double apart = static_cast<double>(k - j) / (kNodes - 1) / kAlike;
      covariance(k, j) = std::exp(-0.5 * apart * apart) + (k == j ? 1e-6 : 0.0);
    }
  }
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  const Eigen::MatrixXd columns = tents * root;
  for (Index k = 0; k < kNodes; ++k) shapes.add(usual, fmt::format("ocv {}", k), columns.col(k));
}

/// The resistance over the size of the current: tents that are wider at higher rates.
VectorXd rate_tent(const VectorXd& rate, double node) {
  constexpr double kWidth = 0.8;  // of ln(rate)
  return (1.0 - (rate.cwiseAbs().array() / node).log().abs() / kWidth).max(0.0).matrix();
}

struct VoltageState {
  VectorXd rate, warmth, charge, steepness, drop;  ///< 1C; 10 K from 25 degC; from 60 % SOC; of the OCV; 100 mV
};

void resistance_shapes(const Shown& shown, const VoltageState& x, const VectorXd& drop, Shapes& shapes) {
  constexpr double kStep = 3.0, kBent = 0.2, kUntested = 0.06, kWanders = 5.0, kHistory = 5.0;
  const VectorXd& rate = x.rate;
  shapes.add(kStep, "current", rate);
  shapes.add(kStep, "current warmth", times(rate, x.warmth));
  shapes.add(kStep, "current warmth^2", times(rate, x.warmth.cwiseAbs2()));
  shapes.add(kStep, "current soc", times(rate, x.charge));
  shapes.add(kStep, "current soc^2", times(rate, x.charge.cwiseAbs2()));
  shapes.add(kStep, "current soc^3", times(rate, times(x.charge, x.charge.cwiseAbs2())));
  shapes.add(kStep, "current steepness", times(rate, x.steepness));
  shapes.add(kStep, "current steepness^2", times(rate, x.steepness.cwiseAbs2()));
  const VectorXd bend = times(rate, rate.cwiseAbs()) / 3.0;
  shapes.add(kStep, "current rate", bend);
  shapes.add(kStep, "current rate warmth", times(bend, x.warmth));
  shapes.add(kStep, "current rate^2", times(bend, rate.cwiseAbs()) / 3.0);
  // The core is warmer than the surface that is measured, and the electrodes' surfaces emptier than their cores.
  const VectorXd heat = times(x.drop, rate);
  for (const double tau : {60.0, 150.0, 400.0}) {
    shapes.add(kHistory, fmt::format("drop heat {} s", tau), 0.1 * times(drop, shapes.behind(heat, tau)));
  }
  for (const double tau : {10.0, 30.0, 100.0}) {
    const VectorXd load = 0.5 * shapes.behind(rate, tau);
    shapes.add(kHistory, fmt::format("current load {} s", tau), times(rate, load));
    if (tau != 30.0) shapes.add(kHistory, fmt::format("current rate load {} s", tau), times(bend, load));
  }
  const VectorXd late = ((shapes.time().array() - shapes.time()(0)) / 600.0 - 0.5).matrix();
  shapes.add(kWanders, "current time", times(rate, late));
  shapes.add(kWanders, "current time^2", times(rate, late.cwiseAbs2()));
  const std::vector<double>& currents = shown.model.car.cell.current_breakpoints_a;
  for (const double node : {0.25, 1.0, 2.0, 3.0, 4.5}) {
    const VectorXd bent = times(rate, rate_tent(rate, node));
    const double current = node * shown.model.car.cell.capacity_ah;
    const bool tested = !currents.empty() && current >= currents.front() && current <= currents.back();
    double usual = tested ? kBent : kUntested;
    shapes.add(usual, fmt::format("current near {}C", node), bent);
    shapes.add(usual, fmt::format("current near {}C warmth", node), times(bent, x.warmth));
    shapes.add(usual, fmt::format("current near {}C soc", node), times(bent, x.charge));
  }
  // Below that it is noise of the sensor at rest, which a shape of its own would hide from the noise model.
  constexpr double kCharging = 0.1;
  if ((rate.array() < -kCharging).any()) shapes.add(kBent, "charging", rate.cwiseMin(0.0));
}

void voltage_shapes(const Shown& shown, Shapes& shapes) {
  constexpr double kDrop = 3.0, kBeyond = 0.4;
  constexpr double kTenth = 0.1, kSteep = 0.8;
  const BatteryResponse& b = shown.base.battery;
  const VectorXd temperature =
      shown.comparison.facts.temperature_c.size() > 0 ? shown.comparison.facts.temperature_c : b.temperature_c;
  const double cells =
      shown.comparison.channels[0].name == "voltage" ? 1.0 : shown.model.car.battery.cells_in_series;
  const VoltageState x{rate_of(shown), ((temperature.array() - 25.0) / 10.0).matrix(),
                       ((b.soc.array() - 0.6) / 0.4).matrix(), (b.ocv_slope_v.array() - kSteep).matrix(),
                       b.drop_v / kTenth};
  const VectorXd drop = x.drop * (kTenth * kTenth * cells / shapes.size());
  shapes.add(kDrop, "drop", drop);
  shapes.add(kDrop, "drop warmth", times(drop, x.warmth));
  // Where the tables end they are held: 4 % a kelvin that a resistance goes on to change, more or less.
  const std::vector<double>& known = shown.model.car.cell.temperature_breakpoints_c;
  if (!known.empty()) {
    shapes.add(kBeyond, "colder than the tables",
               times(drop, (known.front() - temperature.array()).max(0.0).matrix()));
    shapes.add(kBeyond, "warmer than the tables",
               times(drop, (temperature.array() - known.back()).max(0.0).matrix()));
  }
  resistance_shapes(shown, x, drop, shapes);
  for (const double tau : {1.0, 3.0, 10.0, 30.0}) {
    const VectorXd late = shapes.behind(x.rate, tau);
    shapes.add(kFast, fmt::format("behind {} s", tau), late);
    shapes.add(kFast, fmt::format("behind {} s warmth", tau), times(late, x.warmth));
    shapes.add(kFast, fmt::format("behind {} s soc", tau), times(late, x.charge));
    if (tau >= 10.0) shapes.add(kFast, fmt::format("behind {} s steepness", tau), times(late, x.steepness));
  }
  for (const double tau : {100.0, 300.0, 1000.0}) {
    const VectorXd late = shapes.behind(x.rate, tau);
    shapes.add(kSlow, fmt::format("behind {} s", tau), late);
    shapes.add(kSlow, fmt::format("behind {} s warmth", tau), 0.5 * times(late, x.warmth));
    if (tau < 300.0) shapes.add(kSlow, fmt::format("behind {} s steepness", tau), times(late, x.steepness));
  }
  ocv_shapes(b.soc, kOcv, shapes);
}

void heat_shapes(const Shown& shown, Shapes& shapes) {
  constexpr double kLevel = 0.02, kHeat = 0.7, kOther = 0.15, kBegin = 0.2, kStandsWarm = 0.15;
  const BatteryResponse& b = shown.base.battery;
  const CellParameters& cell = shown.model.car.cell;
  const VectorXd rate = rate_of(shown);
  // Kelvin in 100 s.
  const VectorXd heat = times(b.drop_v, b.current_a) * (100.0 / (cell.mass_kg * cell.heat_capacity_j_per_kg_k));
  VectorXd stopped(rate.size());
  for (Index row = 0; row < rate.size(); ++row) {
    stopped(row) = shown.comparison.facts.stopped[static_cast<std::size_t>(row)];
  }
  const VectorXd since = (shapes.time().array() - shapes.time()(0)).matrix();
  if (cell.surface_lag_s > 0.0) {
    // The cell within and its surface begin each as warm as they happen to be.
    shapes.add(kBegin, "1", VectorXd::Ones(rate.size()));
    const VectorXd beginning = (-since / cell.surface_lag_s).array().exp().matrix();
    shapes.add(kBegin, "beginning", beginning);
    // A surface that loses heat is colder than what is within, by a share of its rise above the air. One that
    // begins as warm as what is within has yet to become so.
    const VectorXd& air = shown.comparison.facts.ambient_above_model_k;
    const double ambient = shown.model.car.environment.ambient_c + (air.size() > 0 ? air(0) : 0.0);
    shapes.add(kStandsWarm, "rise at the beginning",
               (b.temperature_c(0) - ambient) * (1.0 - beginning.array()).matrix());
  } else {
    shapes.add(kLevel, "1", VectorXd::Ones(rate.size()));
  }
  for (const double tau : {20.0, 80.0, 300.0}) {
    shapes.add(kHeat, fmt::format("heat behind {} s", tau), shapes.behind(heat, tau));
  }
  for (const double tau : {1000.0, 4000.0}) {
    shapes.add(kHeat, fmt::format("heat behind {} s", tau), 2.0 * shapes.behind(heat, tau));
  }
  for (const double tau : {300.0, 3000.0}) {
    shapes.add(kOther, fmt::format("current behind {} s", tau), shapes.behind(rate, tau));
    shapes.add(kOther, fmt::format("stop behind {} s", tau), shapes.behind(stopped, tau));
  }
  shapes.add(kOther, "time", since / 600.0);
}

void terminal_shapes(const Shown& shown, Shapes& shapes) {
  constexpr double kLevel = 0.5, kCurrent = 0.5;
  const VectorXd rate = rate_of(shown);
  shapes.add(kLevel, "1", VectorXd::Ones(rate.size()));
  shapes.add(kCurrent, "current", rate);
  shapes.add(kCurrent, "current step", shifted(shapes.time(), rate, 0.05) - shifted(shapes.time(), rate, -0.05));
  shapes.add(kCurrent, "behind 1 s", shapes.behind(rate, 1.0));
  shapes.add(kCurrent, "behind 10 s", shapes.behind(rate, 10.0));
}

void soc_shapes(const Shown& shown, Shapes& shapes) {
  constexpr double kLevel = 0.2, kDrawn = 3.0, kRest = 3.0;
  const VectorXd& soc = shown.base.battery.soc;
  const VectorXd drawn = (soc(0) - soc.array()).matrix();
  const VectorXd ones = VectorXd::Ones(soc.size());
  shapes.add(kLevel, "1", ones);
  // The first rest is read from the open-circuit voltage: where that is steep, its error of millivolts is little
  // charge.
  shapes.add(kRest, "1 at rest", ones * (soc_per_millivolt(shown.base.battery) / shapes.size()));
  // A BMS counts from full, by another capacity; or from the rest.
  shapes.add(kDrawn, "missing", ones - soc);
  shapes.add(kDrawn, "drawn", drawn);
  shapes.add(kDrawn, "drawn^2", drawn.cwiseAbs2());
  shapes.add(kDrawn, "time", (shapes.time().array() - shapes.time()(0)).matrix() / 600.0);
}

}  // namespace

double usual_size(const BalanceChannel& channel, double cells_in_series) {
  if (channel.name == "power") return 1.0;
  if (channel.name == "speed") return 0.2;
  if (channel.name == "motor_speed") return 30.0;
  if (channel.name == "motor_torque") return 1.0;
  if (channel.balance == Balance::kHeat) return 1.0;
  if (channel.name == "soc") return 5e-3;
  return channel.name == "voltage" ? 5e-3 : 2e-3 * cells_in_series;
}

std::vector<Shape> anonymous_shapes(const Shown& shown) {
  std::vector<Shape> out;
  for (std::size_t c = 0; c < shown.comparison.channels.size(); ++c) {
    const BalanceChannel& channel = shown.comparison.channels[c];
    Shapes shapes(shown, c);
    if (c == 0) {
      voltage_shapes(shown, shapes);
    } else if (channel.name == "soc") {
      soc_shapes(shown, shapes);
    } else if (channel.balance == Balance::kVoltage) {
      terminal_shapes(shown, shapes);
    } else if (channel.balance == Balance::kHeat) {
      heat_shapes(shown, shapes);
    } else {
      car_shapes(shown, channel, shapes);
    }
    for (Shape& shape : shapes.out) out.push_back(std::move(shape));
  }
  return out;
}

}  // namespace voltlap::plant
