// SPDX-License-Identifier: Apache-2.0
#include "race/intervention.hpp"

namespace voltlap::plant {
namespace {

using Kind = can::PlantFaultKind;

void override_switch(can::SwitchOverride by, bool& state) {
  if (by != can::SwitchOverride::kAutomatic) state = by == can::SwitchOverride::kOn;
}

void clear_all(Car& car, SensorFaults& sensors) {
  for (Contactor* c : {&car.contactors.air_plus, &car.contactors.air_minus, &car.contactors.precharge}) {
    c->set_fault(ContactorFault::kNone);
    c->set_slow(0.0);
  }
  for (MotorDrive& drive : car.drives) {
    drive.inverter.set_stuck(false);
    drive.inverter.set_share(1.0);
  }
  car.contactors.precharge_resistor_open = false;
  for (std::size_t cell = 0; cell < car.pack().cells(); ++cell) car.pack().scale_resistance(cell, 1.0);
  sensors = {};
}

[[nodiscard]] bool has_part(const can::PlantFault& fault, const Car& car) {
  switch (fault.fault) {
    case Kind::kCellLost:
    case Kind::kCellFrozen:
    case Kind::kCellOffset: return fault.index < car.pack().cells();
    case Kind::kCellGain:
    case Kind::kCellResistanceScale: return fault.index < car.pack().cells() && fault.value > 0;
    case Kind::kThermistorLost:
    case Kind::kThermistorOffset: return fault.index < car.parameters().sensors.temperature_count;
    case Kind::kBrakeLost: return fault.index < 2;
    case Kind::kAirPlusSlow:
    case Kind::kAirMinusSlow:
    case Kind::kPrechargeSlow:
    case Kind::kInverterFollows: return fault.value >= 0;
    case Kind::kAirPlusChatters:
    case Kind::kAirMinusChatters: return fault.value > 0;
    default: return true;
  }
}

}  // namespace

void override_pedals(const can::DriverOverride& by, Pedals& pedals) {
  if (by.accelerator_ok) pedals.accelerator = by.accelerator_ppm * 1e-6;
  if (by.brake_ok) pedals.brake = by.brake_ppm * 1e-6;
}

void override_switches(const can::DriverOverride& by, Switches& switches) {
  override_switch(by.ts_on, switches.ts_on);
  override_switch(by.ready_to_drive, switches.ready_to_drive);
  override_switch(by.reset, switches.reset);
  override_switch(by.shutdown, switches.shutdown_closed);
}

bool apply_plant_fault(const can::PlantFault& fault, Car& car, SensorFaults& sensors) {
  if (!has_part(fault, car)) return false;
  const auto cell = [&]() -> SensorFaults::Channel& { return SensorFaults::at(sensors.cells, fault.index); };
  const auto thermistor = [&]() -> SensorFaults::Channel& {
    return SensorFaults::at(sensors.thermistors, fault.index);
  };
  switch (fault.fault) {
    case Kind::kClearAll: clear_all(car, sensors); break;
    case Kind::kAirPlusWelded: car.contactors.air_plus.set_fault(ContactorFault::kWelded); break;
    case Kind::kAirMinusWelded: car.contactors.air_minus.set_fault(ContactorFault::kWelded); break;
    case Kind::kPrechargeWelded: car.contactors.precharge.set_fault(ContactorFault::kWelded); break;
    case Kind::kPrechargeResistorOpen: car.contactors.precharge_resistor_open = true; break;
    case Kind::kAirPlusStuckOpen: car.contactors.air_plus.set_fault(ContactorFault::kOpen); break;
    case Kind::kAirMinusStuckOpen: car.contactors.air_minus.set_fault(ContactorFault::kOpen); break;
    case Kind::kPrechargeStuckOpen: car.contactors.precharge.set_fault(ContactorFault::kOpen); break;
    case Kind::kAirPlusSlow: car.contactors.air_plus.set_slow(fault.value * 1e-3); break;
    case Kind::kAirMinusSlow: car.contactors.air_minus.set_slow(fault.value * 1e-3); break;
    case Kind::kPrechargeSlow: car.contactors.precharge.set_slow(fault.value * 1e-3); break;
    case Kind::kAirPlusChatters: car.contactors.air_plus.chatter(fault.value * 1e-3); break;
    case Kind::kAirMinusChatters: car.contactors.air_minus.chatter(fault.value * 1e-3); break;
    case Kind::kInverterStuck:
      for (MotorDrive& drive : car.drives) drive.inverter.set_stuck(true);
      break;
    case Kind::kInverterFollows:
      for (MotorDrive& drive : car.drives) drive.inverter.set_share(fault.value * 0.01);
      break;
    case Kind::kCellLost: cell().lost = true; break;
    case Kind::kCellOffset: cell().offset = fault.value * 1e-3; break;
    case Kind::kThermistorLost: thermistor().lost = true; break;
    case Kind::kThermistorOffset: thermistor().offset = fault.value * 0.1; break;
    case Kind::kCurrentLost: sensors.current_lost = true; break;
    case Kind::kApps1Offset: sensors.apps1_offset_v = fault.value * 1e-3; break;
    case Kind::kBrakeLost: sensors.brake_lost[fault.index] = true; break;
    case Kind::kCellFrozen: cell().frozen = true; break;
    case Kind::kCellGain: cell().gain = fault.value * 1e-3; break;
    case Kind::kCurrentOffset: sensors.current_offset_a = fault.value * 0.01; break;
    case Kind::kCurrentReversed: sensors.current_gain = -1.0; break;
    case Kind::kCurrentFrozen: sensors.current_frozen = true; break;
    case Kind::kDcLinkStuck: sensors.dc_link_v = fault.value * 0.1; break;
    case Kind::kInterlockOpen: sensors.interlock_open = true; break;
    case Kind::kIsolationFault: sensors.isolation_fault = true; break;
    case Kind::kCellResistanceScale: car.pack().scale_resistance(fault.index, fault.value * 0.01); break;
  }
  return true;
}

}  // namespace voltlap::plant
