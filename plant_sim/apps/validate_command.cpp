// SPDX-License-Identifier: Apache-2.0
#include "apps/validate_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "identify/validation.hpp"
#include "report/atomic_file.hpp"

namespace voltlap::plant {
namespace {

nlohmann::ordered_json json_of(const FileValidation& v) {
  nlohmann::ordered_json out = {{"file", v.file},
                                {"rms_v", v.rms_v},
                                {"rms_v_above_10_soc", v.rms_v_above_10_soc},
                                {"bias_v", v.bias_v},
                                {"max_error_v", v.max_error_v}};
  out["temperature_rms_c"] =
      v.temperature_rms_c ? nlohmann::ordered_json(*v.temperature_rms_c) : nlohmann::ordered_json(nullptr);
  out["ah"] = v.ah;
  out["soc_start"] = v.soc_start;
  out["soc_start_from"] = v.soc_start_from;
  out["strokes"] = v.strokes;
  out["current_hold"] = name_of(v.hold);
  out["current_hold_from"] = v.hold_from;
  out["voltage_lag_s"] = v.voltage_lag_s;
  out["rms_v_with_lag"] = v.rms_v_with_lag;
  out["repairs"] = v.repairs;
  return out;
}

void print(std::FILE* to, const FileValidation& v) {
  fmt::print(to,
             "{}\n  RMS {:.1f} mV ({:.1f} mV above 10 % SOC), bias {:+.1f} mV, largest {:.0f} mV, over {} "
             "discharge stroke{}, {:.3f} Ah\n",
             v.file, 1e3 * v.rms_v, 1e3 * v.rms_v_above_10_soc, 1e3 * v.bias_v, 1e3 * v.max_error_v, v.strokes,
             v.strokes == 1 ? "" : "s", v.ah);
  fmt::print(to, "  SOC {:.3f} at the start, from {}; current {} (found from {})\n", v.soc_start, v.soc_start_from,
             name_of(v.hold), v.hold_from);
  if (v.temperature_rms_c) fmt::print(to, "  temperature RMS {:.2f} K\n", *v.temperature_rms_c);
  if (v.voltage_lag_s > 0.0) {
    fmt::print(to,
               "  defect of the recording: its voltage trails its current by {:.2f} s (first order); with that lag "
               "in the model {:.1f} mV\n",
               v.voltage_lag_s, 1e3 * v.rms_v_with_lag);
  }
  for (const std::string& repair : v.repairs) fmt::print(to, "  {}\n", repair);
}

}  // namespace

ValidateCommand::ValidateCommand(CLI::App& app)
    : command_(
          app.add_subcommand("validate", "A cell file against recordings of that cell that it was not made from")) {
  command_->add_option("cell", cell_, "Cell file: name or path")->required();
  command_->add_option("data", files_, "Tables of time, current and voltage; CSV, also gzipped")->required();
  command_->add_option("--map", map_,
                       "Role map: name or path; default: by column names, or a shipped map by its header");
  command_->add_option("--temperature", temperature_c_, "degC of recordings that have no temperature column")
      ->capture_default_str();
  command_->add_option("--cells-in-series", series_, "Cells in series behind the recorded voltage")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  command_->add_option("--cells-in-parallel", parallel_, "Cells in parallel behind the recorded current")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  add_output_file(*command_, "--json", json_, "Write the errors of each file as JSON");
  command_->footer(
      "RMS and bias are weighted by time and count discharge strokes; the bias is model minus recording.\n"
      "Example: voltlap validate cell.toml drive.csv.gz --json errors.json");
}

int ValidateCommand::run(const DataFolder& data) {
  const CellParameters cell = load_cell(data, cell_, "cell");
  std::optional<AtomicFile> json;
  if (!json_.empty()) json.emplace(json_);
  std::optional<RoleMap> map;
  if (!map_.empty()) map = load_role_map(data.find("maps", map_, "--map"));
  nlohmann::ordered_json out = {
      {"cell", cell.name}, {"version", VOLTLAP_VERSION}, {"files", nlohmann::ordered_json::array()}};
  for (const std::string& file : files_) {
    const CellLog log = read_cell_log(file, map ? &*map : nullptr, data, {-1e300, 1e300, series_, parallel_});
    const FileValidation result = validate(cell, log, {temperature_c_});
    print(summary_stream({json_}), result);
    out["files"].push_back(json_of(result));
  }
  if (json) {
    json->write(out.dump(2) + "\n");
    json->commit();
  }
  return kExitOk;
}

}  // namespace voltlap::plant
