// SPDX-License-Identifier: Apache-2.0
#include "charge/charge_run.hpp"

#include <algorithm>
#include <cmath>

#include "can_dbc/tables.hpp"
#include "core/demand.hpp"
#include "race/actuators/command_receiver.hpp"
#include "race/sensors/sensor_frames.hpp"

namespace voltlap::plant {
namespace {

constexpr double kTick_s = can::kTickMs * 1e-3;
constexpr double kSwitch_s = 1.0;         // after power-on: every ECU has heard every sensor
constexpr double kAfter_s = 2.0;          // after the end: contactors have opened and say so
constexpr double kIdle_s = 6.0 * 3'600.0;  // chosen; the BMS has ended a charge long before
constexpr double kHopeless_s = 10.0;       // of a fault, or in such air: longer than any node takes to begin
constexpr double kWaits_s = 600.0;         // of anything else: longer than a precharge and its cooling
constexpr double kFlows_a = 0.05;         // half of the charger's step
constexpr std::uint32_t kTicksPerSample = 1'000;
constexpr double kCoulombsPerAh = 3'600.0, kJoulesPerWh = 3'600.0;

class Run {
 public:
  Run(const ChargeOptions& options, PlantBus& bus, ChargeObserver& observer)
      : options_(options),
        bus_(bus),
        observer_(observer),
        step_s_(kTick_s * options.ticks_per_step),
        car_(options.vehicle, false, step_s_),
        frames_(car_.parameters(), options.seed, options.pedal_sensors) {
    VOLTLAP_DEMAND(options.ticks_per_step > 0);
    bus_.attach(observer);
    car_.charger.plugged = true;
    result_.begin_soc = car_.pack().soc_mean();
    result_.temperature_max_c = car_.pack().temperature_max_c();
    open_voltages();
    result_.begin_spread_v = result_.end_spread_v();
  }

  ChargeResult run() {
    while (!over_) tick();
    finish();
    return result_;
  }

 private:
  void tick() {
    (void)bus_.begin_tick(tick_);
    const double time_s = tick_ * kTick_s;
    switches_.charge = time_s >= kSwitch_s && !result_.reached;
    if (options_.hand) {
      options_.hand({time_s, car_, frames_.faults, switches_.shutdown_closed, switches_.charge});
    }
    if (tick_ % static_cast<std::uint32_t>(options_.ticks_per_step) == 0) advance_plant();
    tx_.clear();
    const Instant now = Instant::from_ms(tick_ * can::kTickMs);
    frames_.send(now, car_, Pedals{}, switches_, tx_);
    commands_.receive(now, bus_.exchange(tx_), car_);
    account(time_s);
    if (tick_ % kTicksPerSample == 0) sample(time_s);
    ++tick_;
    end_when_over(tick_ * kTick_s);
  }

  void advance_plant() {
    car_.step(0.0);
    car_.renew(step_s_);
    const Pack& pack = car_.pack();
    for (std::size_t i = 0; i < pack.cells(); ++i) {
      if (pack.cell_voltage(i) <= result_.highest_cell_v) continue;
      result_.highest_cell_v = pack.cell_voltage(i);
      result_.highest_cell = i;
    }
    energy_j_ -= pack.voltage() * car_.pack_current_a() * step_s_;
    result_.temperature_max_c = std::max(result_.temperature_max_c, pack.temperature_max_c());
  }

  void account(double time_s) {
    const can::ChargePhase phase = commands_.charge().phase;
    if (double* spent = spent_in(phase)) *spent += kTick_s;
    const bool held = phase == can::ChargePhase::kResting && std::isnan(result_.first_held_s);
    if (held) result_.first_held_s = time_s;
    if (phase != can::ChargePhase::kWaiting && waited_) idle_s_ = 0.0;
    waited_ = phase == can::ChargePhase::kWaiting;
    const bool against = !switches_.shutdown_closed && !car_.pack().bleeding().empty();
    const bool idle = std::abs(car_.pack_current_a()) < kFlows_a && car_.pack().bleeding().empty();
    idle_s_ = idle ? idle_s_ + kTick_s : 0.0;
    against_s_ = against ? against_s_ + kTick_s : 0.0;
    result_.bled_open_s = std::max(result_.bled_open_s, against_s_);
  }

  /// How long nothing may flow in what the BMS does now: nobody stands there who would mend what it waits for.
  [[nodiscard]] double idle_most_s() const {
    const can::ChargeStatus& said = commands_.charge();
    if (said.phase != can::ChargePhase::kWaiting) return kIdle_s;
    if (said.reason == can::ChargeReason::kTemperature) return air_may_be_charged_in() ? kIdle_s : kHopeless_s;
    const bool hopeless =
        said.reason == can::ChargeReason::kFault || said.reason == can::ChargeReason::kNoChargerInPack;
    return hopeless ? kHopeless_s : kWaits_s;
  }

  /// Cells that stand too cold or too hot come to it by themselves.
  [[nodiscard]] bool air_may_be_charged_in() const {
    const VehicleParameters& car = car_.parameters();
    return car.environment.ambient_c > car.bms.charge_temperature_min_c &&
           car.environment.ambient_c < car.bms.temperature_max_c;
  }

  [[nodiscard]] double* spent_in(can::ChargePhase phase) {
    switch (phase) {
      case can::ChargePhase::kWaiting: return &result_.waiting_s;
      case can::ChargePhase::kCharging: return &result_.charging_s;
      case can::ChargePhase::kResting: return &result_.resting_s;
      case can::ChargePhase::kBleeding: return &result_.bleeding_s;
      default: return nullptr;
    }
  }

  void open_voltages() {
    const Pack& pack = car_.pack();
    result_.lowest_open_v = result_.highest_open_v = pack.tables().ocv_v(pack.cell_soc(0), pack.cell_temperature_c(0));
    for (std::size_t i = 1; i < pack.cells(); ++i) {
      const double open_v = pack.tables().ocv_v(pack.cell_soc(i), pack.cell_temperature_c(i));
      result_.lowest_open_v = std::min(result_.lowest_open_v, open_v);
      result_.highest_open_v = std::max(result_.highest_open_v, open_v);
    }
  }

  [[nodiscard]] double coldest_c() const {
    double coldest_c = car_.pack().cell_temperature_c(0);
    for (std::size_t i = 1; i < car_.pack().cells(); ++i) {
      coldest_c = std::min(coldest_c, car_.pack().cell_temperature_c(i));
    }
    return coldest_c;
  }

  void sample(double time_s) {
    const Pack& pack = car_.pack();
    open_voltages();
    double highest_v = 0.0;
    for (std::size_t i = 0; i < pack.cells(); ++i) highest_v = std::max(highest_v, pack.cell_voltage(i));
    observer_.on_sample({.time_s = time_s, .soc = pack.soc_mean(), .soc_min = pack.cell_soc(pack.emptiest_cell()),
                         .soc_max = pack.cell_soc(pack.fullest_cell()), .cell_min_v = pack.cell_voltage_min(),
                         .cell_max_v = highest_v, .open_spread_v = result_.end_spread_v(),
                         .current_a = -car_.pack_current_a(), .asked_a = commands_.charge().current_asked_ma * 1e-3,
                         .pack_v = pack.voltage(), .temperature_c = pack.temperature_max_c(),
                         .cells_bled = pack.bleeding().size(), .phase = commands_.charge().phase,
                         .reason = commands_.charge().reason});
    if (options_.to_soc < 1.0 && pack.soc_mean() >= options_.to_soc) result_.reached = true;
  }

  void end_when_over(double time_s) {
    const can::ChargePhase phase = commands_.charge().phase;
    if (!result_.reached && phase != can::ChargePhase::kNone) {
      result_.phase = phase;
      result_.reason = commands_.charge().reason;
      result_.faults = commands_.bms().faults;
      const can::ContactorCommand& said = commands_.contactors();
      result_.off_cell = said.suspect_why == can::SuspectWhy::kUneven ? said.suspect : -1;
    }
    const bool ended = phase == can::ChargePhase::kFull || phase == can::ChargePhase::kStopped || result_.reached;
    const bool open = !car_.contactors.air_plus.closed() && !car_.contactors.air_minus.closed();
    if (!(ended && open)) ended_s_ = time_s;
    if (observer_.stop_requested()) result_.stopped = over_ = true;
    if (time_s - ended_s_ >= kAfter_s || time_s >= options_.duration_max_s) over_ = true;
    if (idle_s_ >= idle_most_s()) result_.idle = over_ = true;
  }

  void finish() {
    open_voltages();
    result_.full = result_.phase == can::ChargePhase::kFull;
    result_.time_s = result_.stopped ? tick_ * kTick_s : ended_s_;
    result_.end_soc = car_.pack().soc_mean();
    result_.end_soc_min = car_.pack().cell_soc(car_.pack().emptiest_cell());
    result_.end_temperature_min_c = coldest_c();
    result_.end_temperature_max_c = car_.pack().temperature_max_c();
    result_.too_cold = result_.end_temperature_min_c - car_.parameters().bms.charge_temperature_min_c <
                       car_.parameters().bms.temperature_max_c - result_.end_temperature_max_c;
    result_.bms_counts = commands_.bms().soc_ok;
    result_.bms_soc = commands_.bms().soc_ppm * 1e-6;
    result_.charge_in_ah = -car_.charge_out_c() / kCoulombsPerAh;
    result_.energy_in_wh = energy_j_ / kJoulesPerWh;
    result_.charger_wh = car_.charger_energy_j() / kJoulesPerWh;
    result_.bled_ah = car_.pack().bleed_charge_c() / kCoulombsPerAh;
    result_.bled_wh = car_.pack().bleed_energy_j() / kJoulesPerWh;
    result_.ticks = tick_;
    result_.frames = bus_.frames_sent();
  }

  const ChargeOptions& options_;
  PlantBus& bus_;
  ChargeObserver& observer_;
  double step_s_;
  Car car_;
  SensorFrames frames_;
  CommandReceiver commands_;
  Switches switches_{.shutdown_closed = true};
  TxQueue tx_;
  ChargeResult result_;
  std::uint32_t tick_ = 0;
  double energy_j_ = 0.0, against_s_ = 0.0, idle_s_ = 0.0, ended_s_ = 0.0;
  bool over_ = false, waited_ = false;
};

}  // namespace

ChargeResult run_charge(const ChargeOptions& options, PlantBus& bus, ChargeObserver& observer) {
  return Run(options, bus, observer).run();
}

}  // namespace voltlap::plant
