// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include "bus.hpp"
#include "car.hpp"
#include "settings.hpp"

namespace same_firmware {
namespace {

class Run {
 public:
  Run(const Versions& versions, std::uint64_t seed, Reached& reached, bool record)
      : draw_(seed), reached_(reached), record_(record), seed_(seed), settings_(draw_settings(draw_)),
        bms_(versions, Which::kBms, settings_), master_(versions, Which::kMaster, settings_), car_(settings_, draw_),
        bus_(draw_) {
    ticks_ = static_cast<std::uint32_t>(draw_.between(200, 6'000));
    // One run in ten is where the clock wraps.
    if (draw_.chance(0.1)) now_ms_ = 0U - static_cast<std::uint32_t>(draw_.between(0, 20'000));
    const double often[] = {0.0, 0.0005, 0.003, 0.02};
    trouble_ = draw_.of(often);
    damage_ = draw_.of(often);
    restart_ = draw_.chance(0.3) ? 0.001 : 0.0;
    unsteady_ = draw_.chance(0.3) ? 0.1 : 0.0;
  }

  std::optional<Difference> drive(std::uint64_t calls_max) {
    for (tick_ = 0; tick_ < ticks_ && reached_.calls < calls_max; ++tick_) {
      happen();
      car_.step(heard_);
      bus_.begin_tick();
      car_.send(now_ms_, [this](const auto& message) { bus_.send(message); });
      bus_.forward(last_of_master_);
      if (!step(bms_, Which::kBms)) return difference(Which::kBms);
      bus_.forward(bms_.of_old().frames());
      if (!step(master_, Which::kMaster)) return difference(Which::kMaster);
      const auto sent = master_.of_old().frames();
      last_of_master_.assign(sent.begin(), sent.end());
      listen();
      now_ms_ += next_ms();
    }
    ++reached_.runs;
    return std::nullopt;
  }

 private:
  void happen() {
    if (draw_.chance(trouble_)) car_.plant_trouble();
    if (draw_.chance(damage_)) bus_.plant_damage();
    restart_bms_ = draw_.chance(restart_);
    restart_master_ = draw_.chance(restart_);
  }

  /// Mostly the tick, sometimes early or late, seldom after a long silence or backwards.
  std::uint32_t next_ms() {
    if (!draw_.chance(unsteady_)) return 10;
    if (draw_.chance(0.01)) return static_cast<std::uint32_t>(draw_.between(-100, 100'000));
    return static_cast<std::uint32_t>(draw_.between(0, 30));
  }

  bool step(Pair& pair, Which which) {
    const bool restart = which == Which::kBms ? restart_bms_ : restart_master_;
    if (restart) pair.restart();
    const auto rx = bus_.frames();
    if (record_) steps_[static_cast<std::size_t>(which)].push_back({restart, now_ms_, {rx.begin(), rx.end()}});
    ++reached_.calls;
    return pair.tick(now_ms_, rx);
  }

  void listen() {
    const can::DriveState mode_before = heard_.master.drive_state;
    const can::BmsState bms_before = heard_.bms.state;
    for (const WireFrame& wire : bms_.of_old().frames()) heard_.read(frame_of(wire));
    for (const WireFrame& wire : master_.of_old().frames()) heard_.read(frame_of(wire));
    const can::DriveState mode = heard_.master.drive_state;
    if (mode != mode_before) ++reached_.drive_states[static_cast<std::size_t>(mode)];
    if (heard_.bms.state != bms_before) ++reached_.bms_states[static_cast<std::size_t>(heard_.bms.state)];
    count_new(heard_.master.faults, master_faults_, reached_.master_faults);
    count_new(heard_.bms.faults, bms_faults_, reached_.bms_faults);
    if (heard_.inverter.phase_current_ma != 0) ++reached_.torque_ticks;
    count_failure(bms_, bms_failed_);
    count_failure(master_, master_failed_);
  }
  static void count_new(std::uint32_t bits, std::uint32_t& before, std::array<std::uint64_t, 16>& counts) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (((bits & ~before) >> i & 1U) != 0) ++counts[i];
    }
    before = bits;
  }
  void count_failure(const Pair& pair, bool& before) {
    const bool failed = pair.of_old().failure != nullptr;
    if (failed && !before) ++reached_.failures;
    before = failed;
  }

  Difference difference(Which which) {
    return {which, seed_, tick_, settings_, std::move(steps_[static_cast<std::size_t>(which)])};
  }

  Draw draw_;
  Reached& reached_;
  bool record_;
  std::uint64_t seed_;
  Settings settings_;
  Pair bms_, master_;
  Car car_;
  Bus bus_;
  Heard heard_;
  std::vector<WireFrame> last_of_master_;
  std::array<std::vector<Step>, 2> steps_;
  std::uint32_t now_ms_ = 0, ticks_ = 0, tick_ = 0;
  std::uint32_t master_faults_ = 0, bms_faults_ = 0;
  double trouble_ = 0.0, damage_ = 0.0, restart_ = 0.0, unsteady_ = 0.0;
  bool restart_bms_ = false, restart_master_ = false, bms_failed_ = false, master_failed_ = false;
};

}  // namespace

std::optional<Difference> run(const Versions& versions, std::uint64_t seed, std::uint64_t calls_max, Reached& reached) {
  if (!Run(versions, seed, reached, false).drive(calls_max)) return std::nullopt;
  // Once more with everything written down: the run is the same.
  Reached again;
  return Run(versions, seed, again, true).drive(UINT64_MAX);
}

}  // namespace same_firmware
