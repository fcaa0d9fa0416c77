// SPDX-License-Identifier: Apache-2.0
#include "workloads.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "apps/firmware_loop.hpp"
#include "can_dbc/tables.hpp"
#include "car/battery/pack.hpp"
#include "car/car.hpp"
#include "core/errors.hpp"
#include "core/parameter_file.hpp"
#include "io/bus/trace_hash.hpp"
#include "io/logs/can/can_line.hpp"
#include "io/logs/dbc_decoder.hpp"
#include "race/endurance.hpp"
#include "race/track/lap_solver.hpp"
#include "race/track/track.hpp"

namespace voltlap::benchmarks {
namespace {

using namespace voltlap::plant;

constexpr int kStepsPerTick = 10;
constexpr double kTick_s = can::kTickMs * 1e-3;
constexpr double kStep_s = kTick_s / kStepsPerTick;

/// Car and course of the endurance, read once.
struct Scene {
  VehicleParameters car;
  Track track;
};

std::shared_ptr<const Scene> load_scene() {
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  return std::make_shared<Scene>(Scene{load_vehicle(data, "vtm16e").parameters,
                                       load_track(data.path("tracks/michigan_2015.csv"))});
}

EnduranceOptions race(const Scene& scene, int laps, bool representative) {
  EnduranceOptions options;
  options.vehicle = scene.car;
  options.track = scene.track;
  options.laps = laps;
  options.representative_cell = representative;
  return options;
}

/// Drives away and brakes, over and over: 3 s of torque, 2 s of brake.
class Drive {
 public:
  explicit Drive(const Scene& scene) : car_(scene.car, false, kStep_s) {
    car_.contactors.air_minus.command(true);
    car_.contactors.precharge.command(true);
    for (int i = 0; i < 100; ++i) tick(0.0, 1.0);
    car_.contactors.air_plus.command(true);
    for (int i = 0; i < 100; ++i) tick(0.0, 1.0);
    tick_ = 0;
  }

  void tick() {
    constexpr int kPeriod = 500, kTorque = 300;
    const bool torque = tick_++ % kPeriod < kTorque;
    tick(torque ? 250.0 : 0.0, torque ? 0.0 : 0.4);
  }

 private:
  void tick(double phase_current_a, double brake) {
    car_.inverter.command(phase_current_a, true);
    for (int i = 0; i < kStepsPerTick; ++i) car_.step(brake);
    car_.renew(kTick_s);
  }
  Car car_;
  int tick_ = 0;
};

Amount run_plant_steps(const Scene& scene, Stopwatch& watch) {
  constexpr int kSplits = 10, kTicks = 500;
  Drive drive(scene);
  watch.start();
  for (int split = 0; split < kSplits; ++split) {
    for (int tick = 0; tick < kTicks; ++tick) drive.tick();
    watch.split();
  }
  const double steps = double{kSplits} * kTicks * kStepsPerTick;
  return {steps, steps * kStep_s};
}

Amount run_cell_steps(const Scene& scene, Stopwatch& watch) {
  constexpr int kSplits = 10, kTicks = 2000;
  Pack pack(scene.car, false, kStep_s);
  watch.start();
  for (int split = 0; split < kSplits; ++split) {
    for (int tick = 0; tick < kTicks; ++tick) {
      for (int i = 0; i < kStepsPerTick; ++i) {
        benchmark::DoNotOptimize(pack.advance((tick & 64) != 0 ? 150.0 : -20.0));
      }
      pack.renew(kTick_s, scene.car.environment.ambient_c);
    }
    watch.split();
  }
  const double steps = double{kSplits} * kTicks * kStepsPerTick * static_cast<double>(pack.cells());
  return {steps, steps * kStep_s};
}

/// The frames that each node is handed in a race, tick by tick.
class FrameRecording : public Ecus {
 public:
  struct Tick {
    Instant now;
    std::vector<Frame> bms, master;
  };
  explicit FrameRecording(const VehicleParameters& car) : firmware_(car) {}

  void bms(Instant now, FrameView rx, TxQueue& tx) override {
    ticks.push_back({now, {rx.begin(), rx.end()}, {}});
    firmware_.bms(now, rx, tx);
  }
  void master(Instant now, FrameView rx, TxQueue& tx) override {
    ticks.back().master.assign(rx.begin(), rx.end());
    firmware_.master(now, rx, tx);
  }

  std::vector<Tick> ticks;

 private:
  FirmwareLoop firmware_;
};

/// Watches a race as the command does: every frame is hashed. Splits the time at fixed moments of the race.
class RaceObserver : public EnduranceObserver {
 public:
  explicit RaceObserver(Stopwatch* watch) : watch_(watch) {}
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override { hash_.on_frame(tick, sender, frame); }
  void on_sample(const TimeSample&) override {}
  void on_progress(double, double time_s) override {
    constexpr double kEvery_s = 10.0;
    if (watch_ == nullptr || time_s < next_s_) return;
    next_s_ += kEvery_s;
    watch_->split();
  }
  [[nodiscard]] bool stop_requested() override { return false; }

 private:
  Stopwatch* watch_;
  double next_s_ = 10.0;
  TraceHash hash_;
};

/// The frames of car.dbc in a lap of the race as candump -l writes them.
class LapLog : public EnduranceObserver {
 public:
  explicit LapLog(const Scene& scene) : dbc(VOLTLAP_CAR_DBC), decoder(dbc) {
    FirmwareLoop firmware(scene.car);
    static_cast<void>(run_endurance(race(scene, 1, true), firmware, *this));
  }
  void on_frame(std::uint32_t tick, Sender, const Frame& frame) override {
    if (decoder.find(frame.id) == nullptr) return;  // Orion's, of another file
    time_s = tick * kTick_s;
    std::string line = fmt::format("({:.6f}) can0 {:03X}#", time_s, frame.id & ~Frame::kExtendedFlag);
    for (std::size_t k = 0; k < frame.dlc; ++k) line += fmt::format("{:02X}", frame.data[k]);
    lines.push_back(std::move(line));
  }
  void on_sample(const TimeSample&) override {}
  void on_progress(double, double) override {}
  [[nodiscard]] bool stop_requested() override { return false; }

  std::vector<std::string> lines;
  double time_s = 0.0;
  DbcFile dbc;
  DbcDecoder decoder;
};

Amount run_decoding(const LapLog& log, Stopwatch& watch) {
  constexpr std::size_t kFrames = 20000;
  CanLineState state;
  std::vector<double> values(log.decoder.most_signals());
  std::vector<std::uint64_t> present(presence_words(values.size()));
  std::size_t frames = 0;
  watch.start();
  for (const std::string& line : log.lines) {
    RecordedFrame frame;
    if (parse_can_line(CanFormat::kCandump, line, state, frame) != CanLine::kFrame) continue;
    const CompiledMessage* message = log.decoder.find(frame.id);
    message->decode_all(frame, values, present);
    benchmark::DoNotOptimize(values.data());
    benchmark::ClobberMemory();
    if (++frames % kFrames == 0) watch.split();
  }
  watch.split();
  return {static_cast<double>(frames), log.time_s};
}

std::vector<FrameRecording::Tick> record_a_lap(const Scene& scene) {
  FrameRecording recording(scene.car);
  RaceObserver nobody(nullptr);
  if (!run_endurance(race(scene, 1, true), recording, nobody).finished) {
    throw InputError("benchmark", "a lap that fails", "a car that finishes",
                     "Run ./voltlap endurance --laps 1 to see why");
  }
  return std::move(recording.ticks);
}

Amount run_firmware_ticks(const Scene& scene, const std::vector<FrameRecording::Tick>& ticks, Stopwatch& watch) {
  FirmwareLoop firmware(scene.car);
  TxQueue tx;
  constexpr std::size_t kTicks = 1000;
  const std::size_t used = ticks.size() / kTicks * kTicks;
  watch.start();
  for (std::size_t i = 0; i < used; ++i) {
    tx.clear();
    firmware.bms(ticks[i].now, {ticks[i].bms.data(), ticks[i].bms.size()}, tx);
    tx.clear();
    firmware.master(ticks[i].now, {ticks[i].master.data(), ticks[i].master.size()}, tx);
    if ((i + 1) % kTicks == 0) watch.split();
  }
  return {static_cast<double>(used), static_cast<double>(used) * kTick_s};
}

Amount run_laps(const Scene& scene, Stopwatch& watch) {
  constexpr int kSplits = 10, kSolutions = 4;
  double lap_s = 0.0;
  watch.start();
  for (int split = 0; split < kSplits; ++split) {
    for (int i = 0; i < kSolutions; ++i) lap_s = solve_lap(scene.car, scene.track, LapStart::kFlying).lap_time_s();
    watch.split();
  }
  return {kSplits * kSolutions, kSplits * kSolutions * lap_s};
}

Amount run_endurances(const Scene& scene, bool representative, Stopwatch& watch) {
  constexpr int kLaps = 27;
  watch.start();
  FirmwareLoop firmware(scene.car);
  RaceObserver observer(&watch);
  const EnduranceResult result = run_endurance(race(scene, kLaps, representative), firmware, observer);
  watch.split();
  return {1.0, result.total_time_s};
}

}  // namespace

std::vector<Workload> workloads() {
  const auto scene = load_scene();
  const auto ticks = std::make_shared<const std::vector<FrameRecording::Tick>>(record_a_lap(*scene));
  const auto log = std::make_shared<const LapLog>(*scene);
  return {
      {"plant_step", "1 ms of the whole car, 24 cells", 20, [=](Stopwatch& w) { return run_plant_steps(*scene, w); }},
      {"cell_step", "1 ms of one cell, in a pack of 24", 20, [=](Stopwatch& w) { return run_cell_steps(*scene, w); }},
      {"firmware_tick", "10 ms of BMS and master controller, with the frames of a lap", 20,
       [=](Stopwatch& w) { return run_firmware_ticks(*scene, *ticks, w); }},
      {"lap", "lap solver, Michigan 2015", 20, [=](Stopwatch& w) { return run_laps(*scene, w); }},
      {"endurance", "27 laps, every cell, frames hashed", 8,
       [=](Stopwatch& w) { return run_endurances(*scene, false, w); }},
      {"endurance_representative", "27 laps, one cell for all", 8,
       [=](Stopwatch& w) { return run_endurances(*scene, true, w); }},
      {"decode_frame", "a candump line parsed and all signals of its frame decoded", 20,
       [=](Stopwatch& w) { return run_decoding(*log, w); }},
  };
}

}  // namespace voltlap::benchmarks
