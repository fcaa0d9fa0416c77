// SPDX-License-Identifier: Apache-2.0
#include "apps/identify_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "battery/cell_tables.hpp"
#include "core/errors.hpp"
#include "identify/cell_file.hpp"
#include "identify/rests_and_steps.hpp"
#include "report/atomic_file.hpp"

namespace voltlap::plant {
namespace {

constexpr double kRoom = 25.0;  // degC, where nothing says otherwise
constexpr const char* kThermalFrom = "aesc_e5_2p";

std::pair<double, double> window_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  try {
    std::size_t used_begin = 0, used_end = 0;
    const std::string begin = text.substr(0, colon), end = colon == std::string::npos ? "" : text.substr(colon + 1);
    const double t0 = std::stod(begin, &used_begin), t1 = std::stod(end, &used_end);
    if (used_begin == begin.size() && used_end == end.size() && t1 > t0) return {t0, t1};
  } catch (const std::exception&) {
    // falls through to the message below
  }
  throw InputError("--window", "\"" + text + "\"", "T0:T1 in seconds with T1 above T0, such as 100:3600",
                   "Correct it");
}

}  // namespace

IdentifyCommand::IdentifyCommand(CLI::App& app)
    : command_(app.add_subcommand("identify", "Parameter tables of a cell from its measured tests or drives")) {
  command_->add_option("data", files_, "Tables of time, current and voltage; CSV, also gzipped")->required();
  command_->add_option("--rc", branches_, "RC branches, 1 to 3; default: chosen by held-out pulses, at most 2")
      ->check(whole_number(1, 3));
  command_->add_option("--ocv", ocv_, "OCV from a slow test (a table) or a cell file; default: from the rests");
  command_->add_option("--map", map_,
                       "Role map: name or path; default: by column names, or a shipped map by its header");
  command_->add_option("--temperature", temperatures_, "degC of the files after it that have no temperature column")
      ->allow_extra_args(false);
  command_->add_option("--window", windows_, "T0:T1, seconds: only these rows of the files after it")
      ->allow_extra_args(false);
  command_->add_option("--blocks", blocks_, "SECONDS:even|odd: fit every other block, print the RMS on the rest");
  command_->add_option("--cells-in-series", series_, "Cells in series behind the recorded voltage")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  command_->add_option("--cells-in-parallel", parallel_, "Cells in parallel behind the recorded current")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  add_output_file(*command_, "--out", out_, "Write the cell file (TOML) that --set battery.cell=FILE takes");
  add_output_file(*command_, "--json", json_, "Write everything found as JSON");
  command_->footer("Example: voltlap identify hppc.csv.gz --out cell.toml --json cell.json");
}

std::vector<IdentifyCommand::Recording> IdentifyCommand::recordings() const {
  std::vector<Recording> out;
  Recording next{"", kRoom, -1e300, 1e300, false};
  std::size_t temperature = 0, window = 0, file = 0;
  for (const CLI::Option* option : command_->parse_order()) {
    if (option->get_name() == "--temperature") {
      next.temperature_c = temperatures_.at(temperature++);
      next.temperature_given = true;
    } else if (option->get_name() == "--window") {
      std::tie(next.window_begin_s, next.window_end_s) = window_of(windows_.at(window++));
    } else if (option->get_name() == "data") {
      next.path = files_.at(file++);
      out.push_back(next);
    }
  }
  return out;
}

std::vector<CellLog> IdentifyCommand::read(const DataFolder& data, std::vector<double>& temperatures_c) const {
  std::optional<RoleMap> map;
  if (!map_.empty()) map = load_role_map(data.find("maps", map_, "--map"));
  std::vector<CellLog> logs;
  for (const Recording& recording : recordings()) {
    const LogOptions options{recording.window_begin_s, recording.window_end_s, series_, parallel_};
    logs.push_back(read_cell_log(recording.path, map ? &*map : nullptr, data, options));
    CellLog& log = logs.back();
    double mean = recording.temperature_c;
    if (!log.temperature_c.empty()) {
      double sum = 0.0, count = 0.0;
      for (const double t : log.temperature_c) {
        if (!std::isfinite(t)) continue;
        sum += t;
        count += 1.0;
      }
      if (count > 0.0) mean = sum / count;
    } else if (!recording.temperature_given) {
      log.repairs.push_back(fmt::format("no temperature: {} degC assumed (--temperature)", kRoom));
    }
    temperatures_c.push_back(mean);
  }
  return logs;
}

void IdentifyCommand::take_blocks(IdentifyOptions& options) const {
  if (blocks_.empty()) return;
  const std::size_t colon = blocks_.find(':');
  const std::string which = colon == std::string::npos ? "" : blocks_.substr(colon + 1);
  char* end = nullptr;
  options.block_s = std::strtod(blocks_.c_str(), &end);
  options.fit_even_blocks = which == "even";
  if (!(options.block_s > 0.0) || end != blocks_.c_str() + colon || (which != "even" && which != "odd")) {
    throw InputError("--blocks", "\"" + blocks_ + "\"", "SECONDS:even or SECONDS:odd, such as 60:even",
                     "Correct it");
  }
}

void IdentifyCommand::take_ocv(const DataFolder& data, IdentifyOptions& options) const {
  if (ocv_.empty()) return;
  const bool is_cell = ocv_.ends_with(".toml") || ocv_.find('.') == std::string::npos;
  if (is_cell) {
    constexpr double kOtherCell = 5e-3;  // V; a cell of the same type
    const CellParameters cell = load_cell(data, ocv_, "--ocv");
    const CellTables tables(cell);
    for (int k = 0; k <= 40; ++k) options.ocv.push_back({k / 40.0, tables.ocv(k / 40.0).voltage_v, kOtherCell});
    options.capacity_fallback_ah = cell.capacity_ah;
    return;
  }
  const LogOptions log_options{-1e300, 1e300, series_, parallel_};
  std::optional<RoleMap> map;
  if (!map_.empty()) map = load_role_map(data.find("maps", map_, "--map"));
  const SlowTest slow = ocv_from_slow_test(read_cell_log(ocv_, map ? &*map : nullptr, data, log_options));
  options.ocv = slow.ocv;
  options.capacity_fallback_ah = slow.capacity_ah;
}

void IdentifyCommand::print(const CellTests& tests, const CellParameters& cell) const {
  std::FILE* to = summary_stream({out_, json_});
  fmt::print(to, "{}: {:.3f} Ah, {} to {} V\n", cell.name, cell.capacity_ah, cell.voltage_min_v,
             cell.voltage_max_v);
  for (const TestGroup& group : tests.groups) {
    const IdentifyResult& r = group.result;
    fmt::print(to, "\nat {:.1f} degC{}: {} RC branches, RMS {:.2f} mV, smoothness {}, {} iterations, {:.2f} s\n",
               group.temperature_c, group.current_a > 0.0 ? fmt::format(", {:.0f} A", group.current_a) : "",
               r.model.branches(), 1e3 * r.rms_v, r.smoothness, r.iterations, r.seconds);
    for (const FileFinding& file : r.files) {
      fmt::print(to,
                 "  {}\n    current {} (found from {}); SOC {:.3f} to {:.3f}, {:.3f} by {}; RMS {:.2f} mV over all "
                 "rows, {:.2f} mV from there on\n",
                 file.path, name_of(file.hold), file.hold_from, file.soc_low, file.soc_high, file.anchor.soc,
                 file.anchor.from, 1e3 * file.rms_v, 1e3 * file.rms_pulses_v);
      for (const std::string& repair : file.repairs) fmt::print(to, "    {}\n", repair);
    }
    for (const OrderScore& order : r.orders) {
      fmt::print(to, "  {} branch{}: held-out pulses {:.2f} mV, information criterion {:.0f}\n", order.branches,
                 order.branches == 1 ? "  " : "es", 1e3 * order.heldout_rms_v, order.information_criterion);
    }
    if (r.rms_other_blocks_v) {
      fmt::print(to, "  blocks kept back: RMS {:.2f} mV a cell, {:.3f} V over {} in series\n",
                 1e3 * *r.rms_other_blocks_v, *r.rms_other_blocks_v * series_, series_);
    }
    for (const std::string& note : r.notes) fmt::print(to, "  {}\n", note);
    const Eigen::Index branches = r.model.branches();
    fmt::print(to, "    SOC    Em [V]     R0 [mOhm]  ");
    for (Eigen::Index k = 1; k <= branches; ++k) fmt::print(to, "      R{} [mOhm]  ", k);
    for (Eigen::Index k = 1; k <= branches; ++k) fmt::print(to, "       tau{} [s]  ", k);
    fmt::print(to, "   (+- 95 %; * not excited)\n");
    for (Eigen::Index node = r.model.grid.size(); node-- > 0;) {
      const double soc = r.model.grid.at(node);
      fmt::print(to, "  {:5.3f}  {:8.4f}", soc, r.model.ocv.value(r.model.em, soc));
      for (Eigen::Index table = 0; table <= 2 * branches; ++table) {
        const double value =
            table <= branches ? 1e3 * r.model.r(node, table) : r.model.tau(node, table - branches - 1);
        const double sigma = r.uncertainty.sigma(r.model.em.size() + table * r.model.grid.size() + node);
        fmt::print(to, "  {:9.4g} {:4.0f} %{}", value, std::min(999.0, 196.0 * sigma),
                   is_excited(r, table, node) ? " " : "*");
      }
      fmt::print(to, "\n");
    }
  }
}

int IdentifyCommand::run(const DataFolder& data) {
  IdentifyOptions options;
  options.branches = branches_;
  options.progress = [](const std::string& what) { fmt::print(stderr, "voltlap: {}\n", what); };
  take_blocks(options);
  take_ocv(data, options);
  std::optional<AtomicFile> out, json;
  if (!out_.empty()) out.emplace(out_);
  if (!json_.empty()) json.emplace(json_);
  if (out && branches_ == 3) {
    throw InputError("--out", "--rc 3", "one or two branches", "A cell file holds two; write three to --json");
  }
  std::vector<double> temperatures;
  std::vector<CellLog> logs = read(data, temperatures);
  const bool named = !out_.empty() && out_ != AtomicFile::kStandardOutput;
  std::string name = std::filesystem::path(named ? out_ : files_.front()).filename().string();
  name = name.substr(0, name.find('.'));
  CellTests tests = identify_cell(std::move(logs), temperatures, options);
  const CellParameters cell =
      cell_parameters(tests, load_cell(data, kThermalFrom, "identify"), name, tests.groups[tests.reference].result.notes);
  print(tests, cell);
  if (out) {
    out->write(cell_toml(cell, tests, kThermalFrom));
    out->commit();
  }
  if (json) {
    json->write(identification_json(cell, tests, VOLTLAP_VERSION));
    json->commit();
  }
  return kExitOk;
}

}  // namespace voltlap::plant
