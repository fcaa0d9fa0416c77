// SPDX-License-Identifier: Apache-2.0
// The plant's side of the bus: readings become sealed sensor frames.
#pragma once
#include <array>

#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/tables.hpp"
#include "car/car.hpp"
#include "codec/amk_frames.hpp"
#include "codec/seal.hpp"
#include "race/driver/pi_driver.hpp"
#include "race/sensors/instrument.hpp"
#include "race/sensors/pedal_sensors.hpp"
#include "race/sensors/sensor_faults.hpp"
#include "race/sensors/sensors.hpp"

namespace voltlap::plant {

/// Buttons and circuits that the driver and the track officials operate.
struct Switches {
  bool shutdown_closed = false, ts_on = false, ready_to_drive = false, reset = false, charge = false;
};

/// Sends everything that is due at `now`, each message on the cycle that the DBC gives it.
class SensorFrames {
 public:
  SensorFrames(const VehicleParameters& car, std::uint64_t seed, const PedalSensors& pedal_sensors = {});

  void send(Instant now, const Car& car, const Pedals& pedals, const Switches& switches, TxQueue& tx);

  SensorFaults faults;

 private:
  /// The instruments that move see the truth in every period, also when their frame is not due.
  void follow_slow(const Car& car);
  [[nodiscard]] double surface_at(const Car& car, std::size_t thermistor) const;
  void send_pack(const Car& car, TxQueue& tx);
  void send_pedals(const Pedals& pedals, TxQueue& tx);
  void send_wheels(const Car& car, TxQueue& tx);
  void send_inverter(const Car& car, TxQueue& tx);
  void send_pm100_readings(Instant now, const Car& car, TxQueue& tx);
  void send_amk_readings(Instant now, const Car& car, TxQueue& tx);
  void send_io(const Car& car, const Switches& switches, TxQueue& tx);
  void send_cells(Instant now, const Car& car, TxQueue& tx);
  void send_temperatures(Instant now, const Car& car, TxQueue& tx);
  void send_charger(Instant now, const Car& car, TxQueue& tx);
  void send_motor_temperatures(Instant now, const Car& car, TxQueue& tx);

  const VehicleParameters& parameters_;
  PedalSensors pedal_sensors_;
  Sensors sensors_;
  Instrument pack_current_, pack_voltage_, dc_link_voltage_, phase_current_, motor_speed_;
  std::array<Instrument, codec::kWheels> wheel_motor_speed_, wheel_current_;  // of four motors
  Instrument motor_temperature_, inverter_temperature_;
  Instrument wheel_front_left_, wheel_front_right_, wheel_rear_left_, wheel_rear_right_;
  Instrument apps1_, apps2_, brake_front_, brake_rear_;
  std::vector<Instrument> cells_, thermistors_;
  std::vector<std::int32_t> last_cell_100uv_;  // as sent
  std::int32_t last_current_ma_ = 0;
  bool slow_moves_ = false;
  codec::Sealer sealer_;
};

}  // namespace voltlap::plant
