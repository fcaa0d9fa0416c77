// SPDX-License-Identifier: Apache-2.0
#include "firmware/app/state_space.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace voltlap::app::test {
namespace {

using can::BmsState;
using can::DriveState;

constexpr const char* kNames[] = {"wait 60 ms",     "wait 3 s",       "shutdown switch", "TS button",
                                  "ready button",   "reset button",   "brake",           "pedal",
                                  "no fault",       "a cell too high", "AIR+ welded",    "inverter fault",
                                  "BMS not heard",  "master not heard", "pedals not heard"};
static_assert(sizeof(kNames) / sizeof(kNames[0]) == static_cast<std::size_t>(Deed::kCount));

/// A car and what has been done to it.
struct Car {
  Loop loop;
  Deed fault = Deed::kNoFault;
  bool brake = false, pedal = false;
  std::uint32_t since_ready_button = 1'000'000, since_reset = 1'000'000;  ///< [ms] since it was last seen pressed
  std::string broken;
};

void set_fault(Deed fault, Car& car) {
  Loop& loop = car.loop;
  car.fault = fault;
  loop.cell_100uv = fault == Deed::kCellHigh ? 43'500 : 39'000;
  loop.air_plus_welded = fault == Deed::kAirPlusWelded;
  loop.inverter_follows = fault != Deed::kInverterFault;
  if (fault == Deed::kInverterFault) {
    loop.inverter.state = can::InverterState::kFault;
    loop.inverter.phase_current_ma = loop.pack.pack_current_ma = 0;
  }
  loop.silent.clear();
  if (fault == Deed::kBmsUnheard) loop.silent = {can::BmsStatus::kId, can::BmsLimits::kId, can::ContactorCommand::kId};
  if (fault == Deed::kMasterUnheard) loop.silent = {can::MasterStatus::kId, can::InverterCommand::kId};
  if (fault == Deed::kPedalsUnheard) loop.silent = {can::Pedals::kId};
}

/// The rules, tick by tick.
void judge(const Loop& before, Car& car) {
  const Loop& now = car.loop;
  const auto fail = [&car](const char* what) {
    if (car.broken.empty()) car.broken = what;
  };
  const bool ready = now.in(DriveState::kReadyToDrive), was_ready = before.in(DriveState::kReadyToDrive);
  if (now.command.phase_current_ma != 0 && !ready) fail("torque outside of ready to drive (MST-040)");
  if (now.command.phase_current_ma > 0 && !car.pedal && !before.pedals.apps1_ok) fail("torque without pedal");
  if (ready && !was_ready && !(car.brake && car.since_ready_button <= 60)) {
    fail("ready to drive without brake and button (MST-012, EV.9)");
  }
  const bool air_plus_closes = now.contactors.air_plus_close && !before.contactors.air_plus_close;
  const std::int64_t link = before.inverter.dc_link_voltage_100uv, pack = now.pack.pack_voltage_100uv;
  if (air_plus_closes && link * 100 < pack * 90) fail("AIR+ closes without precharge (BMS-031, EV.5.6)");
  if (air_plus_closes && !before.contactors.precharge_close) fail("AIR+ closes without the precharge relay");
  const std::uint32_t let_go = before.bms.state().faults.latched & ~now.bms.state().faults.latched;
  if (let_go != 0 && car.since_reset > 60) fail("a latched trip is gone without a reset (BMS-023, EV.7.2.3)");
  if (before.in(DriveState::kFault) && !now.in(DriveState::kFault) && car.since_reset > 60) {
    fail("the master leaves its fault without a reset (MST-010)");
  }
  const bool closed = now.contactors.air_plus_close || now.contactors.air_minus_close;
  const bool heard = car.fault != Deed::kBmsUnheard;  // what the car does without commands is the car's
  if (heard && closed && !before.io.shutdown_closed && !now.io.shutdown_closed) {
    fail("contactors closed with the shutdown circuit open (BMS-030, EV.7.2.2)");
  }
  if (closed && now.bms.state().faults.latched != 0 && before.bms.state().faults.latched != 0 &&
      now.bms.state().contactors.state == BmsState::kTsActive) {
    fail("active with a latched trip");
  }
}

void run(std::int32_t ms, Car& car) {
  for (std::int32_t t = 0; t < ms; t += kTickMs) {
    const bool pressed = car.loop.io.rtd_button, reset = car.loop.io.reset_button;
    car.since_ready_button = pressed ? 0 : std::min<std::uint32_t>(car.since_ready_button + kTickMs, 1'000'000);
    car.since_reset = reset ? 0 : std::min<std::uint32_t>(car.since_reset + kTickMs, 1'000'000);
    const Loop before = car.loop;
    car.loop.tick();
    judge(before, car);
  }
}

bool possible(Deed deed, const Car& car) {
  if (deed < Deed::kNoFault) return true;
  return deed == Deed::kNoFault ? car.fault != Deed::kNoFault : car.fault == Deed::kNoFault;
}

void carry_out(Deed deed, Car& car) {
  constexpr std::int32_t kReaction_ms = 60;
  can::VehicleIo& io = car.loop.io;
  switch (deed) {
    case Deed::kWait: break;
    case Deed::kWaitLong: run(3'000, car); return;
    case Deed::kShutdown: io.shutdown_closed = !io.shutdown_closed; break;
    case Deed::kTsOn: io.ts_on_button = !io.ts_on_button; break;
    case Deed::kReadyButton: io.rtd_button = !io.rtd_button; break;
    case Deed::kReset: io.reset_button = !io.reset_button; break;
    case Deed::kBrake:
      car.brake = !car.brake;
      car.loop.brake(car.brake ? 30'000 : 0);
      break;
    case Deed::kPedal:
      car.pedal = !car.pedal;
      car.loop.pedal(car.pedal ? 600 : 0);
      break;
    default: set_fault(deed, car); break;
  }
  run(kReaction_ms, car);
}

/// Class of an age: fresh, longer than a reaction, longer than a start.
unsigned age_class(Instant since, const Loop& loop) {
  const std::int32_t age = (Instant::from_ms(loop.now_ms) - since).ms();
  return age < 100 ? 0 : age < 2'500 ? 1 : 2;
}

using Key = std::array<std::uint32_t, 6>;

Key key_of(const Car& car) {
  const Loop& loop = car.loop;
  const bms::State& bms = loop.bms.state();
  const master::State& master = loop.master.state();
  const can::VehicleIo& io = loop.io;
  const auto bit = [](bool on, unsigned at) { return on ? 1U << at : 0U; };
  const bms::Contactors& c = bms.contactors;
  const std::int32_t link = loop.inverter.dc_link_voltage_100uv;
  const std::uint32_t link_class = link < 600'000 ? 0U : link < 842'000 ? 1U : 2U;
  return {bit(io.shutdown_closed, 0) | bit(io.ts_on_button, 1) | bit(io.rtd_button, 2) | bit(io.reset_button, 3) |
              bit(car.brake, 4) | bit(car.pedal, 5) | static_cast<std::uint32_t>(car.fault) << 8U,
          static_cast<std::uint32_t>(c.state) | static_cast<std::uint32_t>(master.drive.mode) << 8U |
              age_class(c.entered, loop) << 16U | age_class(master.drive.entered, loop) << 20U |
              std::uint32_t{c.precharges} << 24U,
          bit(c.command.air_plus, 0) | bit(c.command.air_minus, 1) | bit(c.command.precharge, 2) | bit(c.opening, 3) |
              bit(c.closed_once, 4) | bit(bms.faults.reset_released, 5) | bit(master.request.armed, 6) |
              bit(master.request.waiting, 7) | bit(loop.command.phase_current_ma != 0, 8) |
              bit(master.drive.rtd_sound, 9) | link_class << 12U,
          bms.faults.latched, master.pedals.latched.bits,
          bit(master.drive.ts_on.held(), 0) | bit(master.drive.rtd.held(), 1) | bit(master.drive.reset.held(), 2)};
}

}  // namespace

const char* name_of(Deed deed) { return kNames[static_cast<std::size_t>(deed)]; }

std::string StateSpace::way_to(std::size_t place) const {
  std::string out;
  for (std::size_t p = place; p != 0; p = places[p].from) {
    out = std::string(name_of(places[p].by)) + (out.empty() ? "" : ", ") + out;
  }
  return "from power-on: " + out;
}

std::vector<std::size_t> StateSpace::dead_ends() const {
  std::vector<std::vector<std::size_t>> back(places.size());
  std::vector<bool> reaches(places.size(), false);
  std::vector<std::size_t> open;
  for (std::size_t p = 0; p < places.size(); ++p) {
    for (const std::size_t next : places[p].to) back[next].push_back(p);
    if (!places[p].drives) continue;
    reaches[p] = true;
    open.push_back(p);
  }
  while (!open.empty()) {
    const std::size_t p = open.back();
    open.pop_back();
    for (const std::size_t before : back[p]) {
      if (reaches[before]) continue;
      reaches[before] = true;
      open.push_back(before);
    }
  }
  std::vector<std::size_t> out;
  for (std::size_t p = 0; p < places.size(); ++p) {
    if (!reaches[p]) out.push_back(p);
  }
  return out;
}

StateSpace explore(std::size_t depth_max) {
  StateSpace out;
  std::map<Key, std::size_t> known;
  std::vector<std::pair<std::size_t, std::unique_ptr<Car>>> frontier;
  auto first = std::make_unique<Car>();
  first->loop.inverter.motor_speed_rpm = 1'000;
  run(1'500, *first);  // until the nodes know the car
  known[key_of(*first)] = 0;
  out.places.emplace_back();
  frontier.emplace_back(0, std::move(first));
  for (std::size_t depth = 1; depth <= depth_max && !frontier.empty() && out.broken.empty(); ++depth) {
    std::vector<std::pair<std::size_t, std::unique_ptr<Car>>> next;
    for (auto& [place, car] : frontier) {
      for (std::uint8_t d = 0; d < static_cast<std::uint8_t>(Deed::kCount) && out.broken.empty(); ++d) {
        const Deed deed = static_cast<Deed>(d);
        if (!possible(deed, *car)) continue;
        auto after = std::make_unique<Car>(*car);
        carry_out(deed, *after);
        ++out.steps;
        const auto [found, fresh] = known.try_emplace(key_of(*after), out.places.size());
        out.places[place].to.push_back(found->second);
        if (!after->broken.empty()) {
          out.broken = after->broken + "; " + out.way_to(place) + ", " + name_of(deed);
        }
        if (!fresh) continue;
        out.places.push_back({place, deed, after->loop.in(DriveState::kReadyToDrive), {}});
        out.depth = depth;
        next.emplace_back(found->second, std::move(after));
      }
      car.reset();
    }
    frontier = std::move(next);
  }
  out.whole = frontier.empty();
  return out;
}

}  // namespace voltlap::app::test
