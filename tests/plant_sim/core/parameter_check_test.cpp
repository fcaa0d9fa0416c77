// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_check.hpp"

#include <functional>

#include "scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ParameterCheck) {
  LoadedVehicle vehicle = load_vehicle(DataFolder(VOLTLAP_SOURCE_DIR "/plant_sim/data"), "vtm16e");

  std::string complaint_after(const std::function<void(VehicleParameters&)>& change) {
    change(vehicle.parameters);
    return complaint([&] { check_consistency(vehicle); });
  }
};

TEST(ParameterCheck, VehicleOfTheProjectIsConsistent) {
  STRCMP_EQUAL("no error", complaint_after([](VehicleParameters&) {}).c_str());
}

TEST(ParameterCheck, BreakpointsThatDoNotRiseAreNamedWithTheirFileAndLine) {
  const std::string message = complaint_after(
      [](VehicleParameters& p) { std::swap(p.cell.soc_breakpoints[1], p.cell.soc_breakpoints[2]); });
  STRCMP_CONTAINS("aesc_e5_2p.toml:", message.c_str());
  STRCMP_CONTAINS("cell.breakpoints.soc", message.c_str());
}

TEST(ParameterCheck, TwoEqualBreakpointsAreRefused) {
  STRCMP_CONTAINS("greater than the one before", complaint_after([](VehicleParameters& p) {
    p.motor.curve_speed_rpm[1] = p.motor.curve_speed_rpm[0];
  }).c_str());
}

TEST(ParameterCheck, CurveWithAPointMissingIsRefused) {
  STRCMP_CONTAINS("motor.curve_torque_nm",
                  complaint_after([](VehicleParameters& p) { p.motor.curve_torque_nm.pop_back(); }).c_str());
  STRCMP_CONTAINS("cell.r0.value", complaint_after([](VehicleParameters& p) {
    p.motor.curve_torque_nm.push_back(0.0);
    p.cell.r0_ohm.value.pop_back();
  }).c_str());
}

TEST(ParameterCheck, OcvNeedsExactlyOneForm) {
  STRCMP_CONTAINS("two open-circuit voltages", complaint_after([](VehicleParameters& p) {
    p.cell.ocv_soc = {0.0, 1.0};
    p.cell.ocv_v = {3.0, 4.0};
  }).c_str());
  STRCMP_CONTAINS("no open-circuit voltage", complaint_after([](VehicleParameters& p) {
    p.cell.ocv_polynomial_v.clear();
    p.cell.ocv_soc.clear();
    p.cell.ocv_v.clear();
  }).c_str());
}

TEST(ParameterCheck, OcvMayBeFlatButNotFall) {
  const auto curve = [](double second) {
    return [second](VehicleParameters& p) {
      p.cell.ocv_polynomial_v.clear();
      p.cell.ocv_soc = {0.0, 0.5, 1.0};
      p.cell.ocv_v = {3.0, second, 4.0};
    };
  };
  STRCMP_EQUAL("no error", complaint_after(curve(3.0)).c_str());
  STRCMP_CONTAINS("no value less", complaint_after(curve(2.999)).c_str());
}

TEST(ParameterCheck, FullTableNeedsAValueForEveryPoint) {
  const auto table = [](std::size_t missing) {
    return [missing](VehicleParameters& p) {
      const auto& c = p.cell;
      p.cell.branches[0].r_ohm.value.clear();
      p.cell.branches[0].r_ohm.table.assign(
          c.soc_breakpoints.size() * c.temperature_breakpoints_c.size() * c.current_breakpoints_a.size() - missing,
          1e-3);
    };
  };
  STRCMP_EQUAL("no error", complaint_after(table(0)).c_str());
  STRCMP_CONTAINS("cell.r1.table", complaint_after(table(1)).c_str());
}

TEST(ParameterCheck, ACellHasOneToFourBranches) {
  for (std::size_t count = 1; count <= 4; ++count) {
    const std::string message = complaint_after([&](VehicleParameters& p) {
      for (std::size_t k = 0; k < 4; ++k) p.cell.branches[k] = k < count ? p.cell.branches[0] : CellBranch{};
    });
    STRCMP_EQUAL("no error", message.c_str());
    LONGS_EQUAL(count, vehicle.parameters.cell.branch_count());
  }
  const std::string none = complaint_after([](VehicleParameters& p) { p.cell.branches = {}; });
  STRCMP_CONTAINS("cell.r1.table", none.c_str());
  STRCMP_CONTAINS("no values", none.c_str());
}

TEST(ParameterCheck, AGapInTheBranchesIsNamed) {
  const std::string message =
      complaint_after([](VehicleParameters& p) { p.cell.branches[3] = p.cell.branches[0]; });
  STRCMP_CONTAINS("cell.r4.value", message.c_str());
  STRCMP_CONTAINS("RC branch 4 without branch 3", message.c_str());
  STRCMP_CONTAINS("Add [r3] and [tau3]", message.c_str());
}

TEST(ParameterCheck, ABranchHasAResistanceAndATimeConstant) {
  const auto half = [this](const std::function<void(CellBranch&)>& change) {
    return complaint_after([&](VehicleParameters& p) {
      p.cell.branches[2] = p.cell.branches[0];
      change(p.cell.branches[2]);
    });
  };
  STRCMP_CONTAINS("cell.tau3.table", half([](CellBranch& b) { b.tau_s = {}; }).c_str());
  STRCMP_CONTAINS("cell.r3.table", half([](CellBranch& b) { b.r_ohm = {}; }).c_str());
  STRCMP_CONTAINS("cell.r3.table", half([](CellBranch& b) {
                                     b = {};
                                     b.r_ohm.per_kelvin = -0.01;
                                   }).c_str());
}

TEST(ParameterCheck, VoltageLimitsStandInOrder) {
  STRCMP_CONTAINS("less than voltage_max_v", complaint_after([](VehicleParameters& p) {
                                               p.cell.voltage_min_v = p.cell.voltage_max_v;
                                             }).c_str());
}

TEST(ParameterCheck, UnknownPowertrainIsRefused) {
  STRCMP_CONTAINS("\"electric\" or \"none\"",
                  complaint_after([](VehicleParameters& p) { p.powertrain.kind = "steam"; }).c_str());
}

TEST(ParameterCheck, FourMotorsAndTheProtocolOfFourInvertersGoTogether) {
  STRCMP_CONTAINS("\"phase_current\", \"pm100\" or \"amk\"", complaint_after([](VehicleParameters& p) {
    p.inverter.protocol = "can";
  }).c_str());
  STRCMP_CONTAINS("one motor", complaint_after([](VehicleParameters& p) { p.inverter.protocol = "amk"; }).c_str());
  STRCMP_EQUAL("no error", complaint_after([](VehicleParameters& p) { p.powertrain.motors = 4; }).c_str());
  for (const char* protocol : {"phase_current", "pm100"}) {
    const std::string told = complaint_after([&](VehicleParameters& p) { p.inverter.protocol = protocol; });
    STRCMP_CONTAINS("powertrain.motors", told.c_str());
    STRCMP_CONTAINS(protocol, told.c_str());
  }
  STRCMP_CONTAINS("3 motors", complaint_after([](VehicleParameters& p) {
    p.inverter.protocol = "amk";
    p.powertrain.motors = 3;
  }).c_str());
}
