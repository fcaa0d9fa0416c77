// SPDX-License-Identifier: Apache-2.0
#include "explain/model/interpolated.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "car/powertrain/motor.hpp"
#include "explain/model/cut_torque.hpp"

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Straight between readings; a row that no reading follows keeps what it holds.
void interpolate(const VectorXd& row_s, const VectorXd& read_s, VectorXd& values) {
  struct Reading {
    double time_s, value;
  };
  std::vector<Reading> read;
  for (Index row = 0; row < values.size(); ++row) {
    if (std::isfinite(values(row)) && (read.empty() || read_s(row) > read.back().time_s))
      read.push_back({read_s(row), values(row)});
  }
  std::size_t next = 0;
  for (Index row = 0; row < values.size(); ++row) {
    while (next < read.size() && read[next].time_s <= row_s(row)) ++next;
    if (!std::isfinite(values(row)) || next == 0 || next == read.size()) continue;
    const Reading &a = read[next - 1], &b = read[next];
    values(row) = a.value + (row_s(row) - a.time_s) / (b.time_s - a.time_s) * (b.value - a.value);
  }
}

/// Mean of the wheels that do not pull: of the first two where there are four.
void derive_speed(plant::Recording& log) {
  std::vector<std::string> wheels = log.numbered("wheel_speed_");
  if (log.find("speed") != nullptr || wheels.empty()) return;
  if (wheels.size() == 4) wheels.resize(2);
  VectorXd mean = VectorXd::Zero(log.rows());
  for (const std::string& wheel : wheels) mean += *log.find(wheel) / static_cast<double>(wheels.size());
  log.signals["speed"] = mean;
  log.derived.insert("speed");
}

/// The torque that the motor of the model makes of its current, the speed it has at the car's.
void derive_torque(const plant::World& model, plant::Recording& log) {
  const plant::VehicleParameters& car = model.car;
  const VectorXd *speed = log.find("speed"), *current = log.find("motor_current");
  const bool drives = current != nullptr || log.find("motor_torque") != nullptr || log.find("accelerator") != nullptr;
  if (drives && log.find("motor_speed") == nullptr && speed != nullptr && car.tyres.radius_m > 0.0) {
    constexpr double kRpm = 2.0 * 3.14159265358979323846 / 60.0;
    log.signals["motor_speed"] = *speed * (car.powertrain.final_drive / car.tyres.radius_m / kRpm);
    log.derived.insert("motor_speed");
  }
  const VectorXd* turns = log.find("motor_speed");
  if (log.find("motor_torque") != nullptr || current == nullptr || turns == nullptr) return;
  VectorXd torque(log.rows());
  for (Index row = 0; row < log.rows(); ++row)
    torque(row) = plant::motor_torque(car.motor, (*current)(row), (*turns)(row));
  log.signals["motor_torque"] = torque;
  log.derived.insert("motor_torque");
}

}  // namespace

plant::Recording interpolated(const plant::World& model, plant::Recording log) {
  for (const char* role : {"speed", "wheel_speed_1", "wheel_speed_2", "motor_speed", "motor_torque",
                           "motor_current", "accelerator", "brake", "lateral_acceleration"}) {
    const auto values = log.signals.find(role);
    const auto read = log.read_s.find(role);
    if (values == log.signals.end() || read == log.read_s.end()) continue;
    interpolate(log.time_s, read->second, values->second);
    read->second = log.time_s;
  }
  derive_speed(log);
  derive_torque(model, log);
  return without_cut_torque(model, std::move(log));
}

}  // namespace voltlap::explain
