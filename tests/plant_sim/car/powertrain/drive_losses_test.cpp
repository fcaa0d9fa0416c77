// SPDX-License-Identifier: Apache-2.0
// What must hold for any drive, whatever its losses are; drives are drawn, their seed is in the message.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "car/car.hpp"
#include "car/powertrain/driveline.hpp"
#include "car/powertrain/full_torque.hpp"
#include "car/powertrain/motor_map.hpp"
#include "fixtures.hpp"
#include "race/driver/road_sense.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr unsigned kDraws = 60;
constexpr double kPeriod_s = 0.01;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  /// 0 once in four, else any order of magnitude between both.
  double term(double low, double high) {
    return between(0.0, 1.0) < 0.25 ? 0.0 : std::exp(between(std::log(low), std::log(high)));
  }

 private:
  std::mt19937 random_;
};

void draw_losses(Draw& draw, VehicleParameters& car) {
  MotorSection& m = car.motor;
  m.efficiency = draw.between(0.0, 1.0) < 0.5 ? 1.0 : draw.between(0.85, 1.0);
  m.winding_loss = draw.between(0.0, 1.0) < 0.8;
  m.winding_resistance_ohm = draw.term(1e-4, 0.02);
  m.winding_per_kelvin = draw.term(1e-3, 0.006);
  m.winding_reference_c = draw.between(0.0, 60.0);
  m.drag_hysteresis_nm = draw.term(0.01, 5.0);
  m.drag_eddy_nm_s = draw.term(1e-5, 1e-2);
  m.drag_windage_nm_s2 = draw.term(1e-8, 1e-5);
  m.rotor_inertia_kg_m2 = draw.term(1e-4, 0.1);
  car.inverter.efficiency = draw.between(0.0, 1.0) < 0.5 ? 1.0 : draw.between(0.9, 1.0);
  car.inverter.loss_w = draw.term(1.0, 300.0);
  car.inverter.loss_w_per_a = draw.term(0.01, 3.0);
  car.inverter.loss_w_per_a2 = draw.term(1e-5, 5e-3);
  car.inverter.loss_w_per_v_a = draw.term(1e-4, 0.02);
  car.powertrain.driveline_efficiency = draw.between(0.85, 1.0);
}

VehicleParameters drawn_car(unsigned seed) {
  Draw draw(seed);
  VehicleParameters car = vtm16e();
  draw_losses(draw, car);
  return car;
}

void drive(Car& car, double seconds, double phase_current_a, double brake) {
  for (long period = 0; period < std::lround(seconds / kPeriod_s); ++period) {
    car.inverter.command(phase_current_a, true);
    for (int i = 0; i < 10; ++i) car.step(brake);
    car.renew(kPeriod_s);
  }
}

void switch_on(Car& car) {
  car.contactors.air_minus.command(true);
  car.contactors.precharge.command(true);
  drive(car, 0.6, 0.0, 0.0);
  car.contactors.air_plus.command(true);
  drive(car, 0.1, 0.0, 0.0);
}

}  // namespace

TEST_GROUP(DriveLosses) {
  /// `what` sees a drawn car, the draw that goes on, and words for a failure.
  template <class What>
  static void for_drawn(const What& what) {
    for (unsigned seed = 1; seed <= kDraws; ++seed) {
      const VehicleParameters car = drawn_car(seed);
      Draw draw(1000 + seed);
      what(car, draw, "seed " + std::to_string(seed));
    }
  }
};

TEST(DriveLosses, GrowWithTorqueAndSpeedAndAreNeverNegative) {
  for_drawn([](const VehicleParameters& car, Draw& draw, const std::string& words) {
    for (int i = 0; i < 50; ++i) {
      const double torque = draw.between(0.1, 80.0), omega = draw.between(0.1, 900.0), copper = draw.between(-20, 160);
      const MotorPoint point = motor_point(car.motor, torque, omega, copper);
      CHECK_TRUE_TEXT(point.loss_w >= -1e-9, words.c_str());
      CHECK_TRUE_TEXT(motor_point(car.motor, 1.1 * torque, omega, copper).loss_w >= point.loss_w - 1e-9, words.c_str());
      CHECK_TRUE_TEXT(motor_point(car.motor, torque, 1.1 * omega, copper).loss_w >= point.loss_w - 1e-9, words.c_str());
      CHECK_TRUE_TEXT(motor_point(car.motor, torque, omega, copper + 20.0).loss_w >= point.loss_w - 1e-9,
                      words.c_str());
      const double volts = draw.between(50.0, 600.0), amperes = point.current_a;
      const double stage = inverter_stage_loss(car.inverter, amperes, volts);
      CHECK_TRUE_TEXT(stage >= 0.0, words.c_str());
      CHECK_TRUE_TEXT(inverter_stage_loss(car.inverter, -1.1 * amperes, volts) >= stage, words.c_str());
      CHECK_TRUE_TEXT(inverter_stage_loss(car.inverter, amperes, 1.1 * volts) >= stage, words.c_str());
    }
  });
}

TEST(DriveLosses, LeaveAnEfficiencyBetweenNoneAndOneThatFallsToNoneWithTheTorque) {
  for_drawn([](const VehicleParameters& car, Draw& draw, const std::string& words) {
    for (int i = 0; i < 50; ++i) {
      const double omega = draw.between(0.01, 900.0), torque = draw.between(0.01, 80.0);
      const double efficiency = motor_point(car.motor, torque, omega, 25.0).efficiency;
      CHECK_TRUE_TEXT(efficiency > 0.0 && efficiency <= 1.0 + 1e-12, words.c_str());
      const double drag = motor_drag(car.motor, omega);
      if (drag > 0.0) {
        CHECK_TRUE_TEXT(efficiency < 1.0, words.c_str());
        CHECK_TRUE_TEXT(motor_point(car.motor, 1e-6 * drag, omega, 25.0).efficiency < 1e-5, words.c_str());
      }
    }
  });
}

TEST(DriveLosses, NeverGiveMoreWhenBrakingThanTheShaftBrings) {
  for_drawn([](const VehicleParameters& car, Draw& draw, const std::string& words) {
    const Inverter inverter(car.inverter);
    for (int i = 0; i < 50; ++i) {
      const double omega = draw.between(0.01, 900.0), torque = -draw.between(1e-6, 80.0);
      const MotorPoint point = motor_point(car.motor, torque, omega, 25.0);
      CHECK_TRUE_TEXT(point.electrical_w >= torque * omega - 1e-9, words.c_str());
      CHECK_TRUE_TEXT(within(point.efficiency, 0.0, 1.0 + 1e-12), words.c_str());
      const double stage = inverter_stage_loss(car.inverter, point.current_a, 96.0);
      const double dc = inverter.dc_power(point.electrical_w) + stage;
      CHECK_TRUE_TEXT(dc >= point.electrical_w - 1e-9, words.c_str());
    }
  });
}

TEST(DriveLosses, ElectricalPowerIsShaftPowerPlusTheHeatOfCopperAndSteel) {
  for_drawn([](const VehicleParameters& car, Draw& draw, const std::string& words) {
    for (int i = 0; i < 50; ++i) {
      const double current = draw.between(-550.0, 550.0), omega = draw.between(-900.0, 900.0);
      const double copper = draw.between(-20.0, 160.0);
      const double torque = motor_torque(car.motor, current, omega), drag = motor_drag(car.motor, omega);
      const double heat = motor_loss(car.motor, current, omega, current * omega >= 0.0, copper) + drag * omega;
      DOUBLES_EQUAL_TEXT(motor_power(car.motor, current, omega, copper), (torque - drag) * omega + heat, 1e-6,
                         words.c_str());
      DOUBLES_EQUAL_TEXT(current, motor_current(car.motor, torque, omega), 1e-9, words.c_str());
      CHECK_TRUE_TEXT(drag * omega >= 0.0, words.c_str());
    }
  });
}

TEST(DriveLosses, FullTorqueOfTheLapIsThatOfTheRoadAtTheSameSpeed) {
  for_drawn([](const VehicleParameters& drawn, Draw& draw, const std::string& words) {
    VehicleParameters car = drawn;
    car.cell = constant_cell();
    for (CellParameterMap* map : {&car.cell.branches[0].r_ohm, &car.cell.branches[1].r_ohm}) map->value = {1e-7};
    car.vehicle.mass_kg = 1e6;  // its speed stays
    car.motor.copper_mass_kg = car.motor.steel_mass_kg = 1e6;  // and its winding as warm as the air
    car.master.power_max_kw = 1e3;
    car.bms.discharge_current_max_a = 1e9;  // there is no firmware on this road
    car.bms.cell_voltage_min_v = 0.0;
    const FullTorque full(car);
    for (int i = 0; i < 4; ++i) {
      Car road(car, true, 0.001);
      switch_on(road);
      road.vehicle().set_speed(draw.between(0.5, 55.0));
      drive(road, 0.1, car.inverter.current_max_a, 0.0);
      const double omega = road.motor_omega_rad_s();
      const double shaft = motor_torque(car.motor, road.phase_current_a(), omega) - motor_drag(car.motor, omega);
      DOUBLES_EQUAL_TEXT(shaft, full.torque_nm(omega), 0.3, words.c_str());
    }
  });
}

TEST(DriveLosses, WhereTheVoltageEndsTheMotorsTorqueTheCurrentFadesStepByStep) {
  for_drawn([](const VehicleParameters& drawn, Draw& draw, const std::string& words) {
    VehicleParameters car = drawn;
    car.battery.contact_resistance_ohm = draw.between(0.0, 0.2);  // the softer the pack, the more a current takes away
    car.motor.curve_voltage_v = draw.between(90.0, 200.0);
    Car road(car, true, 0.001);
    switch_on(road);
    road.vehicle().set_speed(draw.between(20.0, 30.0));
    drive(road, 0.05, car.inverter.current_max_a, 0.0);
    double before = road.phase_current_a(), moved = 0.0, most = before, least = before;
    for (int period = 0; period < 300; ++period) {
      road.inverter.command(car.inverter.current_max_a, true);
      for (int i = 0; i < 10; ++i) {
        road.step(0.0);
        moved += std::abs(road.phase_current_a() - before);
        before = road.phase_current_a();
        most = std::max(most, before);
        least = std::min(least, before);
      }
      road.renew(kPeriod_s);
    }
    // To and fro once, beside what the renewal of the pack's tables moves.
    CHECK_TRUE_TEXT(moved <= 2.0 * (most - least) + 30.0, (words + ", moved " + std::to_string(moved)).c_str());
  });
}

TEST(DriveLosses, TheCurveIsWhatTheShaftGivesAndTakesAtMost) {
  for_drawn([](const VehicleParameters& car, Draw& draw, const std::string& words) {
    const TorqueCurve curve(car.motor);
    for (int i = 0; i < 50; ++i) {
      const double omega = draw.between(1.0, 940.0), most = curve.torque_nm(omega, 90.0);
      const double drag = motor_drag(car.motor, omega);
      for (const double asked : {1e4, -1e4}) {
        const double current = curve.current(asked, omega, 90.0);
        const double shaft = motor_torque(car.motor, current, omega) - drag;
        if (current == 0.0) DOUBLES_EQUAL_TEXT(-drag, shaft, 0.0, words.c_str());
        else DOUBLES_EQUAL_TEXT(std::copysign(most, asked), shaft, 1e-9, words.c_str());
      }
    }
  });
}

TEST(DriveLosses, CloseTheEnergyLedgerInEveryPhaseOfADrive) {
  for_drawn([](const VehicleParameters& parameters, Draw&, const std::string& words) {
    Car car(parameters, true, 0.001);
    switch_on(car);
    EnergyLedger before = car.ledger();
    for (const auto& [current, brake] : {std::pair{450.0, 0.0}, {0.0, 0.0}, {-150.0, 0.0}, {0.0, 0.6}, {0.0, 0.0}}) {
      drive(car, 1.0, current, brake);
      const EnergyLedger phase = car.ledger().since(before);
      DOUBLES_EQUAL_TEXT(0.0, phase.residual_j(), 1e-5, words.c_str());
      CHECK_TRUE_TEXT(phase[EnergyTerm::kMotorHeat] >= -1e-9, words.c_str());
      CHECK_TRUE_TEXT(phase[EnergyTerm::kInverterHeat] >= -1e-9, words.c_str());
      before = car.ledger();
    }
    CHECK_TRUE_TEXT(car.ledger()[EnergyTerm::kKinetic] >= -1e-9, words.c_str());
  });
}

TEST(DriveLosses, ACoastingMotorHoldsTheCarBackAndWarmsItsSteelWithoutACurrent) {
  struct Coasted {
    double speed_mps, heat_j, steel_c, copper_c;
  };
  VehicleParameters parameters = vtm16e();
  const auto coasted = [&]() -> Coasted {
    Car car(parameters, true, 0.001);
    switch_on(car);
    car.vehicle().set_speed(20.0);
    const double before_j = car.energy_out_j();
    drive(car, 3.0, 0.0, 0.0);
    DOUBLES_EQUAL(3.0 * parameters.low_voltage.power_w, car.energy_out_j() - before_j, 20.0);
    return {car.vehicle().speed_mps(), car.ledger()[EnergyTerm::kMotorHeat], car.motor_thermal().steel_c(),
            car.motor_thermal().copper_c()};
  };
  const Coasted alone = coasted();
  DOUBLES_EQUAL(26.85, alone.steel_c, 1e-12);
  parameters.motor.drag_hysteresis_nm = 2.0;
  parameters.motor.drag_eddy_nm_s = 0.005;
  const Coasted dragged = coasted();
  const double shaft_nm = 2.0 + 0.005 * 230.0;  // at the mean of some 230 rad/s
  const double slower = 3.0 * shaft_nm * parameters.powertrain.final_drive / parameters.tyres.radius_m / 315.0;
  DOUBLES_EQUAL(slower, alone.speed_mps - dragged.speed_mps, 0.1 * slower);
  DOUBLES_EQUAL(shaft_nm * 230.0 * 3.0, dragged.heat_j, 0.05 * dragged.heat_j);
  CHECK(dragged.steel_c > dragged.copper_c && dragged.copper_c > 26.85);
  CHECK(dragged.steel_c - 26.85 < dragged.heat_j / (7.0 * 470.0));
  parameters.powertrain.kind = "none";
  DOUBLES_EQUAL(alone.speed_mps, coasted().speed_mps, 1e-12);
}

TEST(DriveLosses, AStandingCarIsLeftStandingAndOneThatCoastsComesToRest) {
  for_drawn([](const VehicleParameters& drawn, Draw&, const std::string& words) {
    VehicleParameters parameters = drawn;
    parameters.motor.drag_hysteresis_nm = 20.0;
    parameters.powertrain.final_drive = 8.0;
    Car car(parameters, true, 0.001);
    switch_on(car);
    DOUBLES_EQUAL_TEXT(0.0, car.vehicle().speed_mps(), 0.0, words.c_str());
    car.vehicle().set_speed(2.0);
    double before = 2.0;
    for (int period = 0; period < 300; ++period) {
      drive(car, 0.01, 0.0, 0.0);
      CHECK_TRUE_TEXT(within(car.vehicle().speed_mps(), 0.0, before + 1e-12), words.c_str());
      before = car.vehicle().speed_mps();
    }
    CHECK_TRUE_TEXT(before < 0.02, words.c_str());
  });
}

TEST(DriveLosses, AnOutputStageLosesOnlyWhileItIsOn) {
  VehicleParameters parameters = vtm16e();
  parameters.inverter.loss_w = 120.0;
  parameters.inverter.loss_w_per_a = 1.5;
  parameters.inverter.loss_w_per_a2 = 0.002;
  parameters.inverter.loss_w_per_v_a = 0.01;
  DOUBLES_EQUAL(120.0 + 1.5 * 200.0 + 0.002 * 4e4 + 0.01 * 200.0 * 90.0,
                inverter_stage_loss(parameters.inverter, -200.0, 90.0), 1e-9);
  Inverter inverter(parameters.inverter);
  DOUBLES_EQUAL(0.0, inverter.stage_loss(0.0, 90.0), 0.0);  // silence
  inverter.command(0.0, true);
  DOUBLES_EQUAL(120.0, inverter.stage_loss(0.0, 90.0), 0.0);
  DOUBLES_EQUAL(0.0, inverter.stage_loss(0.0, 39.0), 0.0);  // too little voltage
  inverter.command(0.0, false);
  DOUBLES_EQUAL(0.0, inverter.stage_loss(0.0, 90.0), 0.0);
}

TEST(DriveLosses, ARotorIsInertiaAtTheWheelsBySquareOfTheGear) {
  for_drawn([](const VehicleParameters& drawn, Draw& draw, const std::string& words) {
    VehicleParameters stated = drawn, reckoned = drawn;
    stated.powertrain.final_drive = reckoned.powertrain.final_drive = draw.between(1.0, 10.0);
    stated.motor.rotor_inertia_kg_m2 = draw.between(0.001, 0.1);
    const double gear = stated.powertrain.final_drive;
    reckoned.motor.rotor_inertia_kg_m2 = 0.0;
    reckoned.powertrain.driveline_inertia_kg_m2 += stated.motor.rotor_inertia_kg_m2 * gear * gear;
    DOUBLES_EQUAL_TEXT(driveline_inertia(reckoned), driveline_inertia(stated), 1e-12, words.c_str());
    Car one(stated, true, 0.001), other(reckoned, true, 0.001);
    for (Car* car : {&one, &other}) {
      switch_on(*car);
      drive(*car, 0.5, 300.0, 0.0);
    }
    DOUBLES_EQUAL_TEXT(other.vehicle().speed_mps(), one.vehicle().speed_mps(), 1e-9, words.c_str());
    DOUBLES_EQUAL_TEXT(0.0, one.ledger().residual_j(), 1e-5, words.c_str());
  });
}

TEST(DriveLosses, ADriverFeelsTheDragOfACoastingMotorAndPushesPastIt) {
  VehicleParameters car = vtm16e();
  const double speed = 15.0, radius = car.tyres.radius_m;
  car.brakes.front_caliper_force_n = 500.0;  // its rear axle comes to its grip first
  const RoadSense without = feel_road(car, {.longitudinal_share = 0.3}, speed);
  car.motor.drag_hysteresis_nm = 5.0;
  const RoadSense with = feel_road(car, {.longitudinal_share = 0.3}, speed);
  const double gear = car.powertrain.final_drive, force_n = 5.0 * gear / radius;
  DOUBLES_EQUAL(force_n / 315.0, without.coasting_mps2 - with.coasting_mps2, 1e-9);
  DOUBLES_EQUAL(5.0 / (0.15 * 550.0), with.accelerator_most - without.accelerator_most, 1e-9);
  CHECK(without.brake_most < 1.0 && with.brake_most < without.brake_most);
}
