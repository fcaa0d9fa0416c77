// SPDX-License-Identifier: Apache-2.0
#include "apps/charge_command.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/flag_checks.hpp"
#include "apps/progress_line.hpp"
#include "apps/run_recorder.hpp"
#include "can_dbc/tables.hpp"
#include "charge/charge_report.hpp"
#include "charge/charge_text.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "io/bus/candump_file.hpp"

namespace voltlap::plant {
namespace {

/// Keeps the samples, writes the frames, says how far it is.
class Recording final : public ChargeObserver {
 public:
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override {
    if (candump) candump->on_frame(tick, sender, frame);
  }
  void on_sample(const ChargeSample& sample) override {
    samples.push_back(sample);
    line.show(fmt::format("{} of the charge, {}, {:.1f} mV apart", duration_words(sample.time_s),
                          phase_name(sample.phase), 1e3 * sample.open_spread_v),
              std::clamp(sample.soc, 0.0, 1.0));
  }
  [[nodiscard]] bool stop_requested() override { return interrupted(); }

  std::optional<CandumpFile> candump;
  std::vector<ChargeSample> samples;
  ProgressLine line{"state of charge"};
};

}  // namespace

ChargeCommand::ChargeCommand(CLI::App& app)
    : command_(
          app.add_subcommand("charge", "Charge the car with the firmware in the loop: charger, shunts, every cell")) {
  car_.add_vehicle(*command_);
  command_->add_option("--from-soc", from_pct_, "State of charge at the begin, in percent")
      ->check(number_between(0.0, 100.0))
      ->capture_default_str();
  command_
      ->add_option("--to-soc", to_pct_, "Below 100 the charger is switched off there; 100: the BMS ends the charge")
      ->check(number_between(0.0, 100.0))
      ->capture_default_str();
  command_
      ->add_option("--soc-spread", soc_spread_pct_,
                   "Cells begin so many points apart from the mean, at most; drawn")
      ->check(number_between(0.0, 50.0))
      ->capture_default_str();
  command_->add_option("--capacity-spread", capacity_spread_pct_, "The same for their capacity, in percent")
      ->check(number_between(0.0, 50.0))
      ->capture_default_str();
  command_->add_option("--resistance-spread", resistance_spread_pct_, "The same for their resistance, in percent")
      ->check(number_between(0.0, 90.0))
      ->capture_default_str();
  command_->add_option("--seed", seed_, "Seed of the drawn cells and of the sensors' noise")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  add_output_file(*command_, "--json", json_, "Write the result as JSON, also when the charge fails");
  add_output_file(*command_, "--csv", csv_, "Write a row every 10 s as CSV; compressed when the name ends in .gz");
  add_output_file(*command_, "--candump", candump_, "Write every frame as a candump log, with simulated time");
  add_output_file(*command_, "--report", report_, "Write a report as one HTML file for any browser, offline");
  command_->footer(
      "The cells differ as drawn, unless --set battery.cells.<n>.* says how: then no cell is drawn. The vehicle needs\n"
      "bms.charger_current_max_a. A FILE named - is standard output; the summary then goes to standard error.\n"
      "Example: voltlap charge --from-soc 10 --report charge.html\n"
      "Exit code: 0 charged, 2 usage or input, 3 the charge was broken off (with its cause), 130 interrupted.");
}

ChargeOptions ChargeCommand::options(const DataFolder& data) {
  refuse_shared_files({{"--json", json_}, {"--csv", csv_}, {"--candump", candump_}, {"--report", report_}});
  CarOptions from = car_;  // before the checks, which look at where each cell begins
  from.settings.push_back(fmt::format("battery.initial_soc={}", 1e-2 * from_pct_));
  const LoadedVehicle loaded = from.load_car(data);
  ChargeOptions out;
  out.vehicle = loaded.parameters;
  out.to_soc = 1e-2 * to_pct_;
  out.seed = seed_;
  if (to_pct_ <= from_pct_) {
    throw InputError("--to-soc", fmt::format("{:g} %", to_pct_), fmt::format("more than --from-soc, {:g} %", from_pct_),
                     "Change one of the two");
  }
  if (out.vehicle.bms.charger_current_max_a == 0.0) {
    throw InputError("vehicle " + out.vehicle.name + ", bms.charger_current_max_a", "0 A: this pack has no charger",
                     "the largest current that the BMS asks of one, 0.1 A or more",
                     "Give it in the car file or with --set");
  }
  drawn_ = out.vehicle.battery.cells.empty();
  if (drawn_) {
    const double spread = drawn_soc_spread(1e-2 * soc_spread_pct_, 1e-2 * from_pct_);
    if (spread < 1e-2 * soc_spread_pct_ - 1e-9) {
      fmt::print(stderr, "From {:g} % on, cells can be {:.1f} points from the mean at most, as drawn here, not {:g}.\n",
                 from_pct_, 100.0 * spread, soc_spread_pct_);
    }
    draw_cells({1e-2 * soc_spread_pct_, 1e-2 * capacity_spread_pct_, 1e-2 * resistance_spread_pct_}, seed_,
               out.vehicle);
  }
  out.pedal_sensors = pedal_sensors(master_config(out.vehicle, loaded.origin));
  (void)bms_config(out.vehicle, loaded.origin);  // a refusal names the line
  return out;
}

int ChargeCommand::run(const DataFolder& data) {
  const ChargeOptions chosen = options(data);
  catch_interrupt();  // before there is a file that must not stay behind
  std::optional<AtomicFile> json, csv, report;
  if (!json_.empty()) json.emplace(json_);
  if (!csv_.empty()) csv.emplace(csv_);
  if (!report_.empty()) report.emplace(report_);
  Recording recording;
  if (!candump_.empty()) recording.candump.emplace(candump_, static_cast<std::uint32_t>(can::kTickMs));

  const auto begin = std::chrono::steady_clock::now();
  FirmwareLoop firmware(chosen.vehicle);
  InProcessLoop bus(firmware);
  const ChargeResult result = run_charge(chosen, bus, recording);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  recording.line.end();
  if (result.stopped) {
    fmt::print(stderr, "Interrupted after {} of the charge; no result file was written.\n",
               duration_words(result.time_s));
    return exit_code_of_interrupt();
  }
  const ChargeDescription run{.vehicle = chosen.vehicle.name, .settings = car_.settings, .seed = seed_,
                              .from_soc = 1e-2 * from_pct_, .to_soc = chosen.to_soc, .drawn_cells = drawn_,
                              .wall_s = wall_s};
  if (json) json->write(charge_json(run, chosen.vehicle, result));
  if (csv) csv->write(charge_csv(recording.samples));
  if (report) report->write(charge_page(run, result, recording.samples));
  for (auto* file : {&json, &csv, &report}) {
    if (*file) (*file)->complete();
  }
  if (recording.candump) recording.candump->complete();
  for (auto* file : {&json, &csv, &report}) {
    if (*file) (*file)->commit();
  }
  if (recording.candump) recording.candump->commit();
  std::FILE* summary = summary_stream({json_, csv_, candump_, report_});
  const std::string what = fmt::format("{}, {} cells{}", run.vehicle, chosen.vehicle.battery.cells_in_series,
                                       drawn_ ? fmt::format(" drawn with seed {}", seed_) : " as set");
  fmt::print(summary, "{}  computed in {:.1f} s\n", charge_text(result, what), wall_s);
  return result.full || result.reached ? kExitOk : kExitFailedRun;
}

}  // namespace voltlap::plant
