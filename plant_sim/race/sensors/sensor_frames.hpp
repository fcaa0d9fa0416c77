// SPDX-License-Identifier: Apache-2.0
// The plant's side of the bus: readings become sealed sensor frames.
#pragma once
#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/tables.hpp"
#include "car/car.hpp"
#include "codec/seal.hpp"
#include "race/driver/pi_driver.hpp"
#include "race/sensors/pedal_sensors.hpp"
#include "race/sensors/sensor_faults.hpp"
#include "race/sensors/sensors.hpp"

namespace voltlap::plant {

/// Buttons and circuits that the driver and the track officials operate.
struct Switches {
  bool shutdown_closed = false, ts_on = false, ready_to_drive = false, reset = false;
};

/// Sends everything that is due at `now`, each message on the cycle that the DBC gives it.
class SensorFrames {
 public:
  SensorFrames(const VehicleParameters& car, std::uint64_t seed, const PedalSensors& pedal_sensors = {});

  void send(Instant now, const Car& car, const Pedals& pedals, const Switches& switches, TxQueue& tx);

  SensorFaults faults;

 private:
  void send_pack(const Car& car, TxQueue& tx);
  void send_pedals(const Pedals& pedals, TxQueue& tx);
  void send_wheels(const Car& car, TxQueue& tx);
  void send_inverter(const Car& car, TxQueue& tx);
  void send_io(const Car& car, const Switches& switches, TxQueue& tx);
  void send_cells(Instant now, const Car& car, TxQueue& tx);
  void send_temperatures(Instant now, const Car& car, TxQueue& tx);
  void send_motor_temperatures(Instant now, const Car& car, TxQueue& tx);

  const VehicleParameters& parameters_;
  PedalSensors pedal_sensors_;
  Sensors sensors_;
  codec::Sealer sealer_;
};

}  // namespace voltlap::plant
