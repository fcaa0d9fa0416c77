// The BMS's configuration for the pack of vtm16e, 24 x cell aesc_e5_2p. Made by voltlap 0.1.0; make it again with
//   voltlap firmware-tables --out FILE
//
// OCV: 32 points from 3 to 4.17 V in steps of 0.1 mV, rounded by at most 0.05 mV.
// Between the points, straight: at most 0.8 mV from the cell's curve, at SOC 0.022.
// A millivolt of reading is worth at most 0.65 % of charge, at SOC 0.50.
// Resistance: 21 points in steps of 1 uOhm, rounded by at most 0.00 %.
// RC branches for a filter: the cell file's two.
#pragma once
#include <cstdint>

#include "bms/config.hpp"

namespace voltlap::bms {
namespace pack_tables {

inline constexpr std::int32_t kOcvSoc[] = {  // ppm of full charge
    0, 14000, 29000, 44000, 59000, 74000, 90000, 106000,
    123000, 140000, 157000, 175000, 193000, 212000, 231000, 251000,
    271000, 297000, 324000, 352000, 383000, 418000, 459000, 497000,
    593000, 645000, 688000, 730000, 784000, 840000, 896000, 1000000,
};
inline constexpr std::int32_t kOcvVoltage[] = {  // 0.1 mV
    30000, 30810, 31619, 32371, 33068, 33713, 34346, 34927,
    35490, 36000, 36461, 36899, 37290, 37655, 37976, 38270,
    38522, 38797, 39027, 39214, 39371, 39501, 39606, 39676,
    39824, 39929, 40045, 40188, 40418, 40708, 41040, 41700,
};
inline constexpr std::int32_t kResistanceSoc[] = {  // ppm of full charge
    0, 50000, 100000, 150000, 200000, 250000, 300000, 350000,
    400000, 450000, 500000, 550000, 600000, 650000, 700000, 750000,
    800000, 850000, 900000, 950000, 1000000,
};
inline constexpr std::int32_t kResistance[] = {  // uOhm of a parallel group, at the reference temperature
    2400, 2400, 2400, 2400, 2400, 2400, 2400, 2400,
    2400, 2400, 2400, 2400, 2400, 2400, 2400, 2400,
    2400, 2400, 2400, 2400, 2400,
};

// For a filter: the circuit of a parallel group at kResistanceSoc, at the reference temperature. kPackConfig holds
// its whole resistance alone, kResistance.
inline constexpr std::int32_t kSeriesResistance[] = {  // uOhm, at once
    1200, 1200, 1200, 1200, 1200, 1200, 1200, 1200,
    1200, 1200, 1200, 1200, 1200, 1200, 1200, 1200,
    1200, 1200, 1200, 1200, 1200,
};
inline constexpr std::int32_t kBranch1Resistance[] = {  // uOhm
    400, 400, 400, 400, 400, 400, 400, 400,
    400, 400, 400, 400, 400, 400, 400, 400,
    400, 400, 400, 400, 400,
};
inline constexpr std::int32_t kBranch1Time[] = {  // ms
    96000, 96000, 96000, 92060, 88130, 84190, 80250, 76315,
    72380, 68440, 64500, 60565, 56630, 52690, 48750, 44815,
    40880, 36940, 33000, 33000, 33000,
};
inline constexpr std::int32_t kBranch2Resistance[] = {  // uOhm
    800, 800, 800, 800, 800, 800, 800, 800,
    800, 800, 800, 800, 800, 800, 800, 800,
    800, 800, 800, 800, 800,
};
inline constexpr std::int32_t kBranch2Time[] = {  // ms
    1072000, 1072000, 1072000, 1015060, 958130, 901190, 844250, 787315,
    730380, 673440, 616500, 559565, 502630, 445690, 388750, 331815,
    274880, 217940, 161000, 161000, 161000,
};

}  // namespace pack_tables

// Whose configuration it is, and its number, by which an image of another car is told. After a
// change by hand set it to 0: whose it is, is not known then.
inline constexpr char kPackCar[] = "vtm16e";
inline constexpr std::uint32_t kPackNumber = 0x9856D1AAU;

inline constexpr Config kPackConfig = [] {
  Config c{};
  c.cells_in_series = 24;
  c.temperature_sensors = 6;
  c.capacity_mah = 55200;                                             // mAh of a parallel group
  c.heat_capacity_j_per_k = 0;                                        // J/K of it
  c.soc_method = SocMethod::kCoulomb;
  c.soc_start_current = Current::from_raw(1000);                      // 1 A
  c.limit_method = LimitMethod::kEquation;
  c.limit_horizon = Duration::from_ms(1000);                          // 1 s
  c.cell_voltage_min = CellVoltage::from_raw(25000);                  // 2.5 V
  c.cell_voltage_max = CellVoltage::from_raw(42000);                  // 4.2 V
  c.discharge_current_max = Current::from_raw(600000);                // 600 A
  c.charge_current_max = Current::from_raw(100000);                   // 100 A
  c.limit_rise_per_s = Current::from_raw(500000);                     // 500 A
  c.derating_start = Temperature::from_raw(550);                      // 55 degC
  c.charge_temperature_min = Temperature::from_raw(0);                // 0 degC
  c.soc_derating_start = Soc::from_raw(0);                            // 0 %
  c.energy_to_go_m = 0;                                               // m; 0: off
  c.energy_to_go_reserve = Soc::from_raw(30000);                      // 3 %
  c.um_per_motor_turn = 523664;                                       // um
  c.cell_voltage_trip_low = CellVoltage::from_raw(24000);             // 2.4 V
  c.cell_voltage_trip_high = CellVoltage::from_raw(42500);            // 4.25 V
  c.temperature_trip = Temperature::from_raw(600);                    // 60 degC
  c.discharge_current_trip = Current::from_raw(720000);               // 720 A
  c.charge_current_trip = Current::from_raw(120000);                  // 120 A
  c.voltage_mismatch = Ratio::from_raw(50000);                        // 5 %
  c.voltage_trip_time = Duration::from_ms(500);                       // 0.5 s
  c.temperature_trip_time = Duration::from_ms(1000);                  // 1 s
  c.measurement_lost_time = Duration::from_ms(500);                   // 0.5 s
  c.current_trip_time = Duration::from_ms(1000);                      // 1 s
  c.mismatch_time = Duration::from_ms(1000);                          // 1 s
  c.implausible_time = Duration::from_ms(1000);                       // 1 s
  c.motor_constant_unm_per_a = 150000;                                // uNm/A
  c.cell_voltage_plausible_min = CellVoltage::from_raw(5000);         // 0.5 V
  c.cell_voltage_plausible_max = CellVoltage::from_raw(50000);        // 5 V
  c.precharge_ratio = Ratio::from_raw(950000);                        // 95 %
  c.precharge_timeout = Duration::from_ms(5000);                      // 5 s
  c.precharge_time_min = Duration::from_ms(20);                       // 0.02 s
  c.precharge_time_unseen = Duration::from_ms(2000);                  // 2 s
  c.precharge_attempts = 4;                                           // in a row
  c.precharge_cooling = Duration::from_ms(10000);                     // 10 s
  c.opening_time = Duration::from_ms(100);                            // 0.1 s
  c.opening_current = Current::from_raw(20000);                       // 20 A
  c.contactor_time = Duration::from_ms(200);                          // 0.2 s
  c.contactor_drop_time = Duration::from_ms(20);                      // 0.02 s
  c.isolation_time = Duration::from_ms(100);                          // 0.1 s
  c.discharge_time = Duration::from_ms(5000);                         // 5 s
  c.dc_link_welded = Ratio::from_raw(500000);                         // 50 %
  c.charger_current_max = Current::from_raw(30000);                   // 30 A
  c.charge_margin = CellVoltage::from_raw(50);                        // 0.005 V
  c.charge_current_end = Current::from_raw(1104);                     // 1.104 A
  c.balancing_voltage_min = CellVoltage::from_raw(39000);             // 3.9 V
  c.balancing_difference = CellVoltage::from_raw(30);                 // 0.003 V
  c.balancing_current_max = Current::from_raw(1000);                  // 1 A
  c.balancing_time_max = Duration::from_ms(86400000);                 // 86400 s
  c.ocv.count = 32;                                                   // points
  c.resistance.count = 21;                                            // points
  c.resistance.reference = Temperature::from_raw(300);                // 30 degC
  c.resistance.ppm_per_kelvin = -14833;                               // 1e-6/K, relative
  for (std::uint8_t i = 0; i < c.ocv.count; ++i) {
    c.ocv.soc[i] = Soc::from_raw(pack_tables::kOcvSoc[i]);
    c.ocv.voltage[i] = CellVoltage::from_raw(pack_tables::kOcvVoltage[i]);
  }
  for (std::uint8_t i = 0; i < c.resistance.count; ++i) {
    c.resistance.soc[i] = Soc::from_raw(pack_tables::kResistanceSoc[i]);
    c.resistance.resistance[i] = Resistance::from_raw(pack_tables::kResistance[i]);
  }
  return c;
}();
static_assert(config_check(kPackConfig) == ConfigError::kNone, "this firmware refuses the pack: make the header again");

}  // namespace voltlap::bms
