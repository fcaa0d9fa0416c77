// SPDX-License-Identifier: Apache-2.0
// One drawn error of one drawn instrument: in its signal it has the right size at the right time, and everywhere else
// the frames are those of a sound car.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include <fmt/format.h>

#include "core/parameter_table.hpp"
#include "fixtures.hpp"
#include "plant_sim/core/scratch.hpp"
#include "race/sensors/sensor_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

using Signals = std::map<std::string, double>;
constexpr int kTicks = 120;
const std::string kFast[] = {"pack_current", "pack_voltage", "dc_link_voltage", "phase_current", "motor_speed", "apps1",
                             "apps2", "brake_front", "brake_rear", "wheel_front_left", "wheel_front_right",
                             "wheel_rear_left", "wheel_rear_right"};

void decode_into(const Frame& f, Signals& out) {
  can::PackSensor pack;
  can::Pedals pedals;
  can::WheelSpeeds wheels;
  can::InverterStatus inverter;
  can::CellVoltages cells;
  can::Temperatures temperatures;
  can::MotorTemperatures motor;
  if (can::decode(f, pack)) {
    out["pack_current"] = pack.pack_current_ma * 1e-3, out["pack_voltage"] = pack.pack_voltage_100uv * 1e-4;
  } else if (can::decode(f, pedals)) {
    out["apps1"] = pedals.apps1_100uv * 1e-4, out["apps2"] = pedals.apps2_100uv * 1e-4;
    out["brake_front"] = pedals.brake_front_mbar * 1e-3, out["brake_rear"] = pedals.brake_rear_mbar * 1e-3;
  } else if (can::decode(f, wheels)) {
    out["wheel_front_left"] = wheels.front_left_mmps * 1e-3, out["wheel_front_right"] = wheels.front_right_mmps * 1e-3;
    out["wheel_rear_left"] = wheels.rear_left_mmps * 1e-3, out["wheel_rear_right"] = wheels.rear_right_mmps * 1e-3;
  } else if (can::decode(f, inverter)) {
    out["motor_speed"] = inverter.motor_speed_rpm, out["phase_current"] = inverter.phase_current_ma * 1e-3;
    out["dc_link_voltage"] = inverter.dc_link_voltage_100uv * 1e-4;
  } else if (can::decode(f, cells)) {
    for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i)
      if (cells.cell_ok[i])
        out[fmt::format("cells.{}", cells.group * can::CellVoltages::kPerFrame + i + 1)] = cells.cell_100uv[i] * 1e-4;
  } else if (can::decode(f, temperatures)) {
    for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i)
      if (temperatures.temperature_ok[i])
        out[fmt::format("thermistors.{}", temperatures.group * can::Temperatures::kPerFrame + i + 1)] =
            temperatures.temperature_dc[i] * 0.1;
  } else if (can::decode(f, motor)) {
    out["motor_temperature"] = motor.motor_dc * 0.1, out["inverter_temperature"] = motor.inverter_dc * 0.1;
  }
}

/// What the wire counts in, a bound on the rounding.
double resolution(const std::string& signal) {
  if (signal == "motor_speed") return 1.0;
  if (signal.find("temperature") != std::string::npos || signal.starts_with("thermistors")) return 0.5;
  if (signal.starts_with("wheel")) return 0.011;
  if (signal.starts_with("cells")) return 0.002;
  return signal.starts_with("brake") || signal.ends_with("current") ? 0.1 : 0.01;
}

double truth_of(const std::string& signal, const Car& car, const Pedals& pedals) {
  const double front = std::abs(car.vehicle().front_omega()) * car.parameters().tyres.radius_m;
  const double rear = std::abs(car.vehicle().rear_omega()) * car.parameters().tyres.radius_m;
  if (signal.starts_with("wheel")) return signal.find("front") != std::string::npos ? front : rear;
  if (signal.starts_with("brake")) return pedals.brake * car.parameters().brakes.full_pedal_pressure_bar;
  if (signal.starts_with("cells.")) return car.pack().cell_voltage(std::stoul(signal.substr(6)) - 1);
  if (signal.starts_with("thermistors.")) {
    const std::size_t sensor = std::stoul(signal.substr(12)) - 1;
    return car.pack().surface_temperature_c(sensor * car.pack().cells() /
                                            static_cast<std::size_t>(car.parameters().sensors.temperature_count));
  }
  const std::map<std::string, double> others = {
      {"pack_current", car.pack_current_a()}, {"pack_voltage", car.pack().voltage()},
      {"dc_link_voltage", car.dc_link_voltage()}, {"phase_current", car.phase_current_a()},
      {"motor_speed", car.motor_omega_rad_s() * 30.0 / M_PI}, {"motor_temperature", car.motor_thermal().copper_c()},
      {"inverter_temperature", car.parameters().environment.ambient_c}, {"apps1", 0.5 + 4.0 * pedals.accelerator},
      {"apps2", 0.25 + 2.0 * pedals.accelerator}};
  return others.at(signal);
}

struct Recording {
  std::vector<Signals> sent, truth;  ///< by tick; `sent` has what was due
};

/// A drive of kTicks, the same for every car with this seed.
Recording record(const VehicleParameters& parameters, std::uint64_t seed, const std::string& signal) {
  Car car(parameters, false, 0.001);
  SensorFrames frames(car.parameters(), 1);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (Contactor* c : {&car.contactors.air_plus, &car.contactors.air_minus}) c->command(true);
  Recording out;
  Pedals pedals;
  TxQueue tx;
  for (std::uint32_t n = 0; n < kTicks; ++n) {
    if (n % 10 == 0) pedals = {unit(random), 0.3 * unit(random)};
    car.inverter.command(400.0 * pedals.accelerator, true);
    for (int i = 0; i < 10; ++i) car.step(0.0);
    car.renew(0.01);
    tx.clear();
    frames.send(Instant::from_ms(n * can::kTickMs), car, pedals, {}, tx);
    out.sent.emplace_back();
    for (const Frame& f : tx) decode_into(f, out.sent.back());
    out.truth.push_back({{signal, truth_of(signal, car, pedals)}});
  }
  return out;
}

/// The reading by the definition, from every truth until now.
double reading(const std::vector<Signals>& truth, std::size_t tick, const std::string& signal,
               const ReadingErrors& e) {
  const auto at = [&](std::size_t k) { return truth[k].at(signal); };
  const auto delay = static_cast<std::size_t>(std::lround(e.delay_s * 100.0));
  const std::size_t until = tick > delay ? tick - delay : 0;
  double x = at(until);
  if (e.lag_s > 0.0) {
    // Many small explicit steps along the straight lines between the truths.
    constexpr int kSteps = 200;
    x = at(0);
    for (std::size_t k = 1; k <= until; ++k) {
      for (int i = 0; i < kSteps; ++i) {
        const double u = at(k - 1) + (at(k) - at(k - 1)) * (i + 0.5) / kSteps;
        x += (u - x) * 0.01 / kSteps / e.lag_s;
      }
    }
  }
  return std::clamp(e.gain * x + e.offset, e.min, e.max);
}

void set(VehicleParameters& car, const std::string& signal, const ReadingErrors& e) {
  const auto fields = std::map<std::string, double>{{"offset", e.offset}, {"gain", e.gain}, {"delay_s", e.delay_s},
                                                    {"lag_s", e.lag_s}, {"min", e.min}, {"max", e.max}};
  const auto is_field = [](std::string_view key, const std::string& field) {
    return key == field || key.starts_with(field + "_");
  };
  for (const auto& [field, value] : fields) {
    for (const ParameterRow& row : parameter_rows()) {
      const std::string section = "sensors." + signal + ".";
      if (!row.key.starts_with(section) || !is_field(row.key.substr(section.size()), field)) continue;
      std::get<double& (*)(VehicleParameters&)>(row.access)(car) = value;
    }
    for (const IndexedRow& row : indexed_rows()) {
      const std::string section = std::string(row.prefix) + ".";
      if (!("sensors." + signal).starts_with(section) || !is_field(row.field, field)) continue;
      row.put(car, std::stoul(("sensors." + signal).substr(section.size())) - 1, value);
    }
  }
}

/// One part of an error, of a size that shows.
ReadingErrors draw_error(std::mt19937_64& random, double typical) {
  std::uniform_real_distribution<double> unit(0.1, 1.0);
  ReadingErrors e;
  switch (std::uniform_int_distribution<int>(0, 5)(random)) {
    case 0: e.offset = 0.2 * typical * unit(random); break;
    case 1: e.gain = 1.0 - 0.3 * unit(random); break;
    case 2: e.delay_s = 0.01 * std::uniform_int_distribution<int>(1, 50)(random); break;
    case 3: e.lag_s = 0.5 * unit(random); break;
    case 4: e.max = 0.9 * typical * unit(random); break;
    default: e.min = 1.1 * typical; break;
  }
  return e;
}

}  // namespace

TEST_GROUP(InstrumentErrors) {};

TEST(InstrumentErrors, ShowInTheirSignalWithTheirSizeAndNowhereElse) {
  std::vector<std::string> signals(std::begin(kFast), std::end(kFast));
  for (const char* more : {"motor_temperature", "inverter_temperature", "cells.1", "cells.13", "cells.24",
                           "thermistors.1", "thermistors.6"}) {
    signals.emplace_back(more);
  }
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    std::mt19937_64 random(seed);
    const std::string signal = signals[seed % signals.size()];
    const Recording sound = record(vtm16e(), seed, signal);
    double typical = 0.0;
    for (const Signals& truth : sound.truth) typical = std::max(typical, std::abs(truth.at(signal)));
    const ReadingErrors error = draw_error(random, typical);
    VehicleParameters car = vtm16e();
    set(car, signal, error);
    const Recording wrong = record(car, seed, signal);
    const std::string trial = fmt::format("seed {}, {}: offset {} gain {} delay {} lag {} min {} max {}", seed, signal,
                                          error.offset, error.gain, error.delay_s, error.lag_s, error.min, error.max);
    for (std::size_t k = 0; k < kTicks; ++k) {
      LONGS_EQUAL_TEXT(sound.sent[k].size(), wrong.sent[k].size(), trial.c_str());
      DOUBLES_EQUAL_TEXT(sound.truth[k].at(signal), wrong.truth[k].at(signal), 0.0, trial.c_str());
      for (const auto& [name, value] : wrong.sent[k]) {
        if (name != signal) {
          DOUBLES_EQUAL_TEXT(sound.sent[k].at(name), value, 0.0, (trial + ", in " + name).c_str());
        } else {
          const double lag_error = error.lag_s > 0.0 ? 1e-3 * typical : 0.0;
          DOUBLES_EQUAL_TEXT(reading(sound.truth, k, signal, error), value, resolution(signal) + lag_error,
                             fmt::format("{}, tick {}", trial, k).c_str());
        }
      }
    }
  }
}

TEST(InstrumentErrors, DelayIsExactToTheTick) {
  Instrument late({.delay_s = 0.05});
  for (int k = 0; k < 40; ++k) DOUBLES_EQUAL(std::max(0, k - 5) * 3.0, late.read(k * 3.0), 0.0);
}

TEST(InstrumentErrors, LagFollowsARampByItsTimeConstant) {
  Instrument slow({.lag_s = 0.2});
  double shown = 0.0;
  for (int k = 0; k <= 500; ++k) shown = slow.read(0.01 * k);
  DOUBLES_EQUAL(5.0 - 0.2, shown, 1e-9);
}

TEST(InstrumentErrors, OfAllCellsHoldsUnlessOneHasItsOwn) {
  VehicleParameters car = vtm16e();
  car.sensors.all_cells.offset = 0.1;
  set(car, "cells.2", {.offset = 0.3});
  const Recording sound = record(vtm16e(), 1, "cells.1"), wrong = record(car, 1, "cells.1");
  DOUBLES_EQUAL(0.1, wrong.sent[0].at("cells.1") - sound.sent[0].at("cells.1"), 1e-9);
  DOUBLES_EQUAL(0.3, wrong.sent[0].at("cells.2") - sound.sent[0].at("cells.2"), 1e-9);
}
