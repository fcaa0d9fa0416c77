// SPDX-License-Identifier: Apache-2.0
// The motor files against themselves: what their headers say by the sheet, their numbers, and the physics between both.
#include <cmath>
#include <fstream>
#include <regex>
#include <string>

#include "car/powertrain/motor.hpp"
#include "car/powertrain/motor_map.hpp"
#include "core/parameter_file.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kRadPerS = M_PI / 30.0;

/// The comment lines before the first number, as one line.
std::string header_of(const std::string& path) {
  std::ifstream file(path);
  std::string out, line;
  while (std::getline(file, line) && line.starts_with("#")) out += line.substr(1);
  return out;
}

}  // namespace

TEST_GROUP(MotorFiles) {
  const DataFolder data{VOLTLAP_SOURCE_DIR "/plant_sim/data"};
  std::string name, header;
  MotorSection motor;
  MotorSummary summary;

  /// The number before or behind the words of the header.
  double said(const std::string& pattern) const {
    std::smatch found;
    if (!std::regex_search(header, found, std::regex(pattern))) FAIL((name + ": the header has no " + pattern).c_str());
    return std::stod(found[1]);
  }
  void within_share(double expected, double actual, double share, const char* what) const {
    DOUBLES_EQUAL_TEXT(expected, actual, share * expected, (name + ": " + what).c_str());
  }
  template <class What>
  void for_each_motor(const What& what) {
    for (const std::string& each : data.names("motors")) {
      name = each;
      header = header_of(data.find("motors", name, "test"));
      motor = load_vehicle(data, "vtm16e", {"motor.model=" + name}).parameters.motor;
      summary = motor_summary(motor);
      what();
    }
  }
};

TEST(MotorFiles, SayThatTheyWereEnteredWithoutTheirSheet) {
  for_each_motor([&] {
    STRCMP_CONTAINS("entered without the sheet at hand: compare them with yours", header.c_str());
  });
}

TEST(MotorFiles, GiveThePeaksOfTheirHeaders) {
  for_each_motor([&] {
    within_share(said("peak torque ([0-9.]+) Nm"), summary.torque_peak_nm, 1e-9, "peak torque");
    within_share(said("peak power ([0-9.]+) kW") * 1e3, summary.power_peak_w, 0.15, "peak power");
    CHECK_TRUE_TEXT(summary.speed_max_rpm <= said("kW, ([0-9]+) rpm"), name.c_str());
  });
}

TEST(MotorFiles, AreMostEfficientAsMuchAndWhereTheirHeadersSay) {
  for_each_motor([&] {
    DOUBLES_EQUAL_TEXT(said("peak efficiency of ([0-9.]+) %"), 100.0 * summary.efficiency_peak, 0.2, name.c_str());
    within_share(said("lies at about ([0-9]+) rpm"), summary.efficiency_peak_rpm, 0.05, "speed of the peak");
    within_share(said("rpm and ([0-9]+) Nm"), summary.efficiency_peak_nm, 0.1, "torque of the peak");
    CHECK_TRUE_TEXT(within(summary.efficiency_peak_rpm / summary.speed_max_rpm, 0.4, 0.9), name.c_str());
  });
}

TEST(MotorFiles, MakeTheirTorqueFromTheirCurrentLessWhatSaturationTakes) {
  for_each_motor([&] {
    const double of_peak = motor.constant_nm_per_a * said("([0-9]+) A peak");
    CHECK_TRUE_TEXT(within(summary.torque_peak_nm / of_peak, 0.74, 1.0), name.c_str());
    const double of_continuous = motor.constant_nm_per_a * said("peak and ([0-9]+) A continuous");
    within_share(of_continuous, said("continuous ([0-9.]+) Nm"), 0.3, "continuous torque");
  });
}

TEST(MotorFiles, HaveTheirKneeWhereBackEmfAndInductanceMeetTheVoltage) {
  // V / sqrt 3 = p w sqrt(psi^2 + (L I)^2), psi = K / (1.5 p sqrt 2), I the peak of the current of the peak torque.
  for_each_motor([&] {
    const double pairs = said("([0-9]+) pole pairs"), inductance = said("([0-9.]+) uH") * 1e-6;
    const double flux = motor.constant_nm_per_a / (1.5 * pairs * std::sqrt(2.0));
    const double current = summary.torque_peak_nm / motor.constant_nm_per_a * std::sqrt(2.0);
    const double phase_v = motor.curve_voltage_v / std::sqrt(3.0);
    std::size_t knee = 0;
    while (motor.curve_torque_nm[knee + 1] > 0.99 * summary.torque_peak_nm) ++knee;
    const double expected_rpm = phase_v / (pairs * std::hypot(flux, inductance * current)) / kRadPerS;
    within_share(expected_rpm, motor.curve_speed_rpm[knee], 0.15, "knee");
    const double no_load_rpm = phase_v / (pairs * flux) / kRadPerS;
    CHECK_TRUE_TEXT(motor.curve_speed_rpm.back() <= no_load_rpm, name.c_str());
    CHECK_TRUE_TEXT(motor.curve_voltage_v <= motor.voltage_max_v, name.c_str());
  });
}

TEST(MotorFiles, StayCoolEnoughAtTheirContinuousTorque) {
  for_each_motor([&] {
    const double omega = 0.7 * summary.speed_max_rpm * kRadPerS, air_c = 50.0;
    const double torque = said("continuous ([0-9.]+) Nm");
    MotorThermal thermal(motor, air_c);
    for (int i = 0; i < 200000; ++i) {
      const MotorPoint point = motor_point(motor, torque, omega, thermal.copper_c());
      const double steel_w = motor_drag(motor, omega) * omega;
      thermal.advance((point.loss_w - steel_w) * 0.05, 0.05, air_c, steel_w * 0.05);
    }
    CHECK_TRUE_TEXT(within(thermal.copper_c(), air_c + 10.0, 150.0), name.c_str());
    CHECK_TRUE_TEXT(torque * omega < summary.power_peak_w, name.c_str());
  });
}
