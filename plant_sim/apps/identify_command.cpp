// SPDX-License-Identifier: Apache-2.0
#include "apps/identify_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "car/battery/cell_tables.hpp"
#include "core/errors.hpp"
#include "learn/identify/preparation/first_estimates.hpp"
#include "learn/identify/result/cell_file.hpp"
#include "learn/identify/result/cell_parameters.hpp"
#include "learn/identify/result/identification_report.hpp"
#include "learn/identify/result/identify_text.hpp"
#include "learn/validate/written_identification.hpp"

namespace voltlap::plant {
namespace {

constexpr double kRoom = 25.0;  // degC, where nothing says otherwise
constexpr const char* kAllMethods = "all";

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

/// Empty where none is recorded, in a column that is blank too.
std::optional<double> mean_of_finite(const std::vector<double>& values) {
  double sum = 0.0, count = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? std::optional(sum / count) : std::nullopt;
}

std::optional<double> first_finite(const std::vector<double>& values) {
  const auto first = std::find_if(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  return first != values.end() ? std::optional(*first) : std::nullopt;
}

}  // namespace

IdentifyCommand::IdentifyCommand(CLI::App& app)
    : command_(app.add_subcommand("identify", what_it_does("identify"))) {
  recordings_.add(*command_)->required();
  command_->add_option("--rc", branches_, "RC branches, 1 to 4; default: chosen by held-out pulses")
      ->check(whole_number(1, 4));
  command_
      ->add_option("--method", method_,
                   "Estimation method of the reference study (ipo, fpo, ilo, flo, ffo), or all: each, the full fit and "
                   "their errors side by side; default: the full fit")
      ->check(one_of({"ipo", "fpo", "ilo", "flo", "ffo", kAllMethods}));
  command_->add_flag("--constant", constant_,
                     "A plain circuit: resistances and time constants with one value for all SOC; the OCV and the laws "
                     "over temperature and current stay free");
  const std::map<std::string, IdentifyOptions::Tables> tables{{"laws", IdentifyOptions::Tables::kByLaws},
                                                              {"tests", IdentifyOptions::Tables::kByTest}};
  command_
      ->add_option("--tables", tables_,
                   "Tests at several temperatures and currents: one table over SOC with laws (laws, the default), or a "
                   "table for each test, straight between them (tests)")
      ->type_name("laws|tests")
      ->transform(CLI::Transformer(tables));
  command_->add_option("--ocv", ocv_, "OCV from a slow test (a table) or a cell file; default: from the rests");
  command_->add_option("--temperature", temperatures_, "degC of the files after it that have no temperature column")
      ->check(number_between(-40.0, 80.0, "In degC; correct the number, or leave the flag out"))
      ->allow_extra_args(false);
  command_
      ->add_option(
          "--cell", cell_,
          "Name of the cell that the files after it are of; several cells give their mean and spread; default: "
          "<n> of files named ..._cell<n>.csv, otherwise one cell")
      ->allow_extra_args(false);
  command_->add_option("--window", windows_, "T0:T1, seconds: only these rows of the files after it")
      ->allow_extra_args(false);
  command_->add_option("--blocks", blocks_, "SECONDS:even|odd: fit every other block, print the RMS on the rest");
  command_->add_option("--capacity", capacity_ah_,
                       "Capacity of one cell, Ah; default: of a whole discharge in the recordings, else only what they "
                       "drew")
      ->check(number_between(0.01, 2000.0, "In Ah of one cell, not mAh and not of the pack: a 21700 has 4"));
  command_->add_option("--mass", mass_kg_, "Mass of one cell, kg (a 21700: 0.07); default: assumed of its form")
      ->check(number_between(0.001, 15.0, "In kg, not g: a cell of 70 g has 0.07"));
  command_->add_option("--size", size_,
                       "Size of one cell: 18650, 21700, 26650, DIAMETERxLENGTH of another cylinder, or "
                       "LENGTHxWIDTHxTHICKNESS of a pouch or can, mm; default: assumed of mass or capacity");
  command_
      ->add_option("--heat-capacity", heat_capacity_j_per_kg_k_,
                   "Of the cell, J/kg/K; default: assumed, 750 to 1000")
      ->check(number_between(300.0, 3000.0, "In J/kg/K, about 1000; that of the whole cell is this times its mass"));
  const std::map<std::string, CurrentHold> holds{{"previous", CurrentHold::kPrevious},
                                                 {"next", CurrentHold::kNext},
                                                 {"linear", CurrentHold::kLinear}};
  command_->add_option("--hold", hold_,
                       "Current between rows: a row's holds on (previous), has held (next), rows are means "
                       "(linear); default: found in each file")
      ->type_name("previous|next|linear")
      ->transform(CLI::Transformer(holds));
  add_instruments();
  add_output_file(*command_, "--out", out_, "Write the cell file (TOML) that --set battery.cell=FILE takes");
  add_output_file(*command_, "--json", json_, "Write everything found as JSON");
  add_output_file(*command_, "--report", report_,
                  "Write model against recordings, coverage and every parameter as one HTML file");
  command_->footer(
      "Examples: voltlap identify hppc.csv.gz --out cell.toml --json cell.json\n"
      "          voltlap identify bench/30c_200a_cell*.csv --method all");
}

void IdentifyCommand::add_instruments() {
  const auto add_limit = [&](const char* flag, double& value, const char* what) {
    command_->add_option(flag, value, std::string("Intervals allow for ") + what)->check(number_from_zero());
  };
  add_limit("--voltage-error", instruments_.voltage_v, "an offset of the voltage up to this, V");
  add_limit("--voltage-gain-error", instruments_.voltage_gain, "a gain error of the voltage up to this, 1");
  add_limit("--current-error", instruments_.current_a, "an offset of the current under load up to this, A");
  add_limit("--current-gain-error", instruments_.current_gain, "a gain error of the current up to this, 1");
  add_limit("--rest-current-error", instruments_.rest_current_a, "an offset of the current at rest up to this, A");
}

std::vector<IdentifyCommand::Recording> IdentifyCommand::recordings() const {
  std::vector<Recording> out;
  Recording next{"", "", kRoom, -1e300, 1e300, false};
  std::size_t temperature = 0, window = 0, cell = 0, file = 0;
  const CLI::Option* waiting = nullptr;  // a flag that no file has followed yet
  for (const CLI::Option* option : command_->parse_order()) {
    const std::string name = option->get_name();
    if (name == "--temperature" || name == "--window" || name == "--cell") waiting = option;
    if (name == "data") waiting = nullptr;
    if (name == "--temperature") {
      next.temperature_c = temperatures_.at(temperature++);
      next.temperature_given = true;
    } else if (name == "--window") {
      std::tie(next.window_begin_s, next.window_end_s) = window_of(windows_.at(window++));
    } else if (name == "--cell") {
      next.cell = cell_.at(cell++);
    } else if (name == "data") {
      next.path = recordings_.files.at(file++);
      out.push_back(next);
    }
  }
  if (waiting != nullptr && waiting->count() == 1) {
    // Behind the files and alone: of all of them.
    const std::string behind = waiting->get_name();
    for (Recording& one : out) {
      if (behind == "--cell") one.cell = next.cell;
      if (behind == "--temperature")
        std::tie(one.temperature_c, one.temperature_given) = std::tuple(next.temperature_c, true);
      if (behind == "--window")
        std::tie(one.window_begin_s, one.window_end_s) = std::tuple(next.window_begin_s, next.window_end_s);
    }
  } else if (waiting != nullptr) {
    throw InputError(waiting->get_name(), "no file after it", "the files that it is of, after it on the command line",
                     "Put it before them");
  }
  return out;
}

std::vector<IdentifyCommand::CellData> IdentifyCommand::read(const DataFolder& data) const {
  const std::vector<std::optional<RoleMap>> maps = recordings_.role_maps(data);
  std::vector<CellData> cells;
  std::size_t file = 0;
  for (const Recording& recording : recordings()) {
    LogOptions options = recordings_.whole();
    options.window_begin_s = recording.window_begin_s;
    options.window_end_s = recording.window_end_s;
    const std::string name = cell_.empty() ? cell_of_file(recording.path) : recording.cell;
    auto cell = std::find_if(cells.begin(), cells.end(), [&](const CellData& c) { return c.name == name; });
    if (cell == cells.end()) cell = cells.insert(cells.end(), {name, {}, {}, false});
    const std::optional<RoleMap>& map = maps.at(file++);
    cell->logs.push_back(read_cell_log(recording.path, map ? &*map : nullptr, data, options));
    CellLog& log = cell->logs.back();
    const std::optional<double> recorded = mean_of_finite(log.temperature_c);
    constexpr double kAgrees_k = 3.0;
    if (recorded && recording.temperature_given && std::abs(*recorded - recording.temperature_c) > kAgrees_k) {
      log.repairs.push_back(fmt::format("--temperature {:g} is not used: the recording has its own, {:.1f} degC",
                                        recording.temperature_c, *recorded));
    }
    std::optional<double> told = recorded;
    if (!told && recording.temperature_given) told = recording.temperature_c;
    if (!told && (told = first_finite(log.ambient_c)))
      log.repairs.push_back(fmt::format("no temperature of the cell: it began as warm as the air, {:.1f} degC", *told));
    if (!told) log.repairs.push_back(fmt::format("no temperature: {} degC assumed (--temperature)", kRoom));
    cell->temperature_told |= told.has_value();
    cell->temperatures_c.push_back(told.value_or(recording.temperature_c));
  }
  return cells;
}

void IdentifyCommand::take_method(IdentifyOptions& options) const {
  if (method_.empty()) return;
  options.method = method_of(method_);  // none for all
  if (branches_ != 0 && branches_ != 2) {
    throw InputError("--rc", fmt::format("{} with --method {}", branches_, method_), "2: the methods have two branches",
                     "Leave out one of the two");
  }
  if (method_ == kAllMethods && (!blocks_.empty() || !ocv_.empty())) {
    throw InputError("--method", "all with --blocks or --ocv", "whole tests with rests: all methods need them",
                     "Leave out the other flag");
  }
  options.branches = 2;
}

void IdentifyCommand::take_constant(const std::vector<CellData>& cells, IdentifyOptions& options) const {
  if (constant_ && !method_.empty()) {
    throw InputError("--constant", "--constant with --method", "one of the two: the methods find tables over SOC",
                     "Leave out one of the two");
  }
  options.constant = constant_;
  options.temperature_told =
      std::any_of(cells.begin(), cells.end(), [](const CellData& cell) { return cell.temperature_told; });
}

void IdentifyCommand::take_blocks(IdentifyOptions& options) const {
  if (blocks_.empty()) return;
  const std::size_t colon = blocks_.find(':');
  const std::string which = colon == std::string::npos ? "" : blocks_.substr(colon + 1);
  char* end = nullptr;
  options.block_s = std::strtod(blocks_.c_str(), &end);
  options.fit_even_blocks = which == "even";
  const bool is_length = end == blocks_.c_str() + colon && options.block_s > 0.0 && std::isfinite(options.block_s);
  if (!is_length || (which != "even" && which != "odd")) {
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
  const std::optional<RoleMap> map = recordings_.first_map(data);
  const SlowTest slow = ocv_from_slow_test(read_cell_log(ocv_, map ? &*map : nullptr, data, recordings_.whole()));
  options.ocv = slow.ocv;
  options.capacity_fallback_ah = slow.capacity_ah;
}

std::vector<CellIdentification> IdentifyCommand::identify_cells(const std::vector<CellData>& cells,
                                                       IdentifyOptions options) const {
  std::vector<CellIdentification> out;
  for (const CellData& cell : cells) {
    options.progress = [&](const std::string& what) {
      fmt::print(stderr, "voltlap: {}{}\n", cells.size() > 1 ? cell.name + ", " : "", what);
    };
    out.push_back(identify_cell(cell.logs, cell.temperatures_c, options));
  }
  return out;
}

std::vector<MethodScore> IdentifyCommand::compare(const std::vector<CellData>& cells,
                                                  const std::vector<CellIdentification>& full,
                                                  IdentifyOptions options) const {
  std::vector<MethodScore> scores;
  for (const Method method : kMethods) {
    options.method = method;
    fmt::print(stderr, "voltlap: method {}\n", name_of(method));
    scores.push_back(method_score(name_of(method), identify_cells(cells, options)));
  }
  scores.push_back(method_score("full", full));
  return scores;
}

ToldBody IdentifyCommand::told_body() const {
  ToldBody told{.mass_kg = mass_kg_, .form = {}, .heat_capacity_j_per_kg_k = heat_capacity_j_per_kg_k_};
  if (!size_.empty()) told.form = cell_form(size_);
  return told;
}

std::vector<std::pair<std::string, std::string>> IdentifyCommand::flags() const {
  std::vector<std::pair<std::string, std::string>> out;
  for (const CLI::Option* option : command_->get_options()) {
    if (option->count() == 0) continue;
    out.emplace_back(option->get_name(), fmt::format("{}", fmt::join(option->results(), " ")));
  }
  return out;
}

std::string IdentifyCommand::cell_name() const {
  const bool named = !out_.empty() && out_ != AtomicFile::kStandardOutput;
  const std::string file = std::filesystem::path(named ? out_ : recordings_.files.front()).filename().string();
  return file.substr(0, file.find('.'));
}

void IdentifyCommand::Outputs::commit() {
  for (auto* file : {&out, &json, &report}) {
    if (*file) (*file)->complete();
  }
  for (auto* file : {&out, &json, &report}) {
    if (*file) (*file)->commit();
  }
}

void IdentifyCommand::open(Outputs& files) const {
  refuse_shared_files({{"--out", out_},
                       {"--json", json_},
                       {"--report", report_},
                       {"--write-map", recordings_.finding.write_map}});
  if (!out_.empty()) files.out.emplace(out_);
  if (!json_.empty()) files.json.emplace(json_);
  if (!report_.empty()) files.report.emplace(report_);
}

std::string IdentifyCommand::json_text(const CellBody& body, const std::vector<CellIdentification>& each,
                                       const std::vector<std::string>& names, const MeanCell* mean,
                                       const std::string& own) {
  if (mean == nullptr) return own;
  std::vector<std::string> texts;
  for (std::size_t c = 0; c < each.size(); ++c) {
    std::vector<std::string> notes;
    texts.push_back(
        identification_json(cell_parameters(each[c], body, names[c], notes), body, each[c], VOLTLAP_VERSION));
  }
  return with_spread(own, *mean, texts);
}

int IdentifyCommand::run(const DataFolder& data) {
  IdentifyOptions options;
  options.branches = branches_;
  options.hold = hold_;
  options.instruments = instruments_;
  options.tables = tables_;
  options.capacity_ah = capacity_ah_;
  take_method(options);
  take_blocks(options);
  take_ocv(data, options);
  IdentificationWriter writer{data, told_body(), cell_name(), recordings_.cells_in_series, {}, {}};
  options.thermal = [&](double capacity_ah) { return writer.thermal(capacity_ah); };
  Outputs files;
  open(files);
  const std::vector<CellData> cells = read(data);
  take_constant(cells, options);
  for (const CellData& cell : cells) writer.names.push_back(cell.name);
  writer.identify = [&](const IdentifyOptions& how) { return identify_cells(cells, how); };
  const WrittenIdentification out = writer.that_holds_most(options);

  std::FILE* to = summary_stream({out_, json_, report_});
  fmt::print(to, "{}", identification_text(out.cell, out.body, out.identified, recordings_.cells_in_series));
  const MeanCell* mean = out.mean ? &*out.mean : nullptr;
  if (mean != nullptr) fmt::print(to, "{}", spread_text(*mean));
  std::vector<MethodScore> scores;
  if (method_ == kAllMethods) scores = compare(cells, out.each, options);
  if (!scores.empty()) fmt::print(to, "\n{}", comparison_text(scores));
  const std::string text = identification_json(out.cell, out.body, out.identified, VOLTLAP_VERSION);
  if (files.out) files.out->write(out.toml);
  if (files.report) {
    files.report->write(identification_report(
        {out.cell, out.body, out.identified, out.each, text, mean, scores, flags()}, VOLTLAP_VERSION));
  }
  if (files.json) {
    const std::string all = json_text(out.body, out.each, writer.names, mean, text);
    files.json->write(scores.empty() ? all : with_methods(all, scores));
  }
  files.commit();
  return kExitOk;
}

}  // namespace voltlap::plant
