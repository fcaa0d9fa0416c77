// SPDX-License-Identifier: Apache-2.0
#include "race/report/compared_run.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/input_files.hpp"
#include "race/report/distance_trace.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kMake = "Give a file that voltlap endurance --json FILE has written";

Json parsed(const std::string& file) {
  std::error_code ignored;
  note_input(file);
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, ignored)) {
    throw InputError(file, in ? "a folder" : std::strerror(errno), "the JSON of a run", kMake);
  }
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  try {
    return Json::parse(text);
  } catch (const Json::out_of_range&) {
    throw InputError(file, "a number beyond every range", "the JSON of a run", kMake);
  } catch (const Json::parse_error& error) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(
                                                      std::min(text.size(), error.byte)), '\n');
    throw InputError(fmt::format("{}:{}", file, line), text.empty() ? "an empty file" : "what is no JSON",
                     "the JSON of a run", kMake);
  }
}

/// A field of the run; its type is checked when it is read.
class Fields {
 public:
  Fields(const std::string& file, const Json& json) : file_(file), json_(json) {}

  const Json& at(const char* key) const {
    if (!json_.is_object() || !json_.contains(key)) {
      throw InputError(fmt::format("{}, {}", file_, key), "no such field", "the JSON of a run", kMake);
    }
    return json_[key];
  }
  double number(const char* key) const {
    const Json& value = at(key);
    if (!value.is_number() || !std::isfinite(value.get<double>())) refuse(key, value, "a number");
    return value.get<double>();
  }
  int count(const char* key) const {
    if (!at(key).is_number_unsigned() || at(key).get<double>() > 1e6) refuse(key, at(key), "a whole number");
    return at(key).get<int>();
  }
  std::string words(const char* key) const {
    if (!at(key).is_string()) refuse(key, at(key), "words");
    return at(key).get<std::string>();
  }
  [[noreturn]] void refuse(const std::string& key, const Json& value, const std::string& expected) const {
    std::string found = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (found.size() > 40) found = found.substr(0, 36) + " ...";
    throw InputError(fmt::format("{}, {}", file_, key), found, expected, kMake);
  }

 private:
  const std::string& file_;
  const Json& json_;
};

/// Shell quotes where they are needed.
std::string quoted(const std::string& word) {
  if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=-+,:") ==
      std::string::npos) {
    return word;
  }
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string text_of(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

/// The command line of a run, from what its result says of it.
std::string command_of(const std::string& file, const Json& json) {
  const std::string start = text_of(json, "lap_start");
  std::string out = "voltlap endurance --vehicle " + quoted(text_of(json, "vehicle"));
  out += (start == "drive" ? " --drive " : " --track ") + quoted(text_of(json, "course"));
  if (start != "drive") {
    out += " --lap-start " + start;
    if (json.contains("laps_asked")) out += " --laps " + json["laps_asked"].dump();
  }
  if (text_of(json, "cells") == "representative") out += " --cells representative";
  if (json.contains("seed")) out += " --seed " + json["seed"].dump();
  if (json.contains("settings") && json["settings"].is_array()) {
    for (const Json& setting : json["settings"]) {
      if (setting.is_string()) out += " --set " + quoted(setting.get<std::string>());
    }
  }
  return out + " --json " + quoted(file);
}

std::vector<std::vector<double>> trace_of(const std::string& file, const Json& json) {
  if (!json.contains("trace") || !json.contains("course_length_m")) {
    throw InputError(file + ", trace",
                     "a run without one, of voltlap " + (json.contains("version") ? text_of(json, "version") : "?"),
                     "the trace by distance that endurance --json writes since it was made",
                     "Make the run again: " + command_of(file, json));
  }
  const Fields fields(file, json["trace"]);
  std::vector<std::vector<double>> out;
  for (const TraceChannel& channel : trace_channels()) {
    const std::string key = fmt::format("trace.{}", channel.name);
    const Json& values = fields.at(channel.name);
    if (!values.is_array()) fields.refuse(key, values, "a list of numbers");
    std::vector<double>& column = out.emplace_back();
    for (const Json& value : values) {
      const bool none = value.is_null() && out.size() > 2;
      if (!none && !value.is_number()) fields.refuse(fmt::format("{}[{}]", key, column.size()), value, "a number");
      column.push_back(none ? std::numeric_limits<double>::quiet_NaN() : value.get<double>());
      const bool backward = out.size() <= 2 && column.size() > 1 && column.back() < column[column.size() - 2];
      if (backward) fields.refuse(fmt::format("{}[{}]", key, column.size() - 1), value, "no less than the one before");
    }
    if (column.size() != out[0].size()) {
      throw InputError(file + ", " + key, fmt::format("{} numbers", column.size()),
                       fmt::format("{}, as distance_m has", out[0].size()), kMake);
    }
  }
  return out;
}

std::vector<ComparedLap> laps_of(const std::string& file, const Json& rows) {
  std::vector<ComparedLap> out;
  for (const Json& row : rows) {
    const Fields fields(file, row);
    out.push_back({fields.count("lap"), fields.number("time_s"), fields.number("energy_kwh"),
                   fields.number("end_soc_pct")});
  }
  return out;
}

void read_failure(const std::string& file, const Fields& fields, ComparedRun& run) {
  run.finished = fields.words("status") == "finished";
  if (run.finished) return;
  const Fields failure(file, fields.at("failure"));
  run.failure_time_s = failure.number("time_s");
  run.failure_cause = failure.words("cause");
}

}  // namespace

const std::vector<ComparedResult>& compared_results() {
  static const std::vector<ComparedResult> rows = {
      {"total_time_s", "total time", "s", 3},
      {"laps", "laps completed", "", 0},
      {"distance_m", "distance driven", "m", 1},
      {"end_soc_pct", "charge left", "%", 2},
      {"energy_out_kwh", "energy out", "kWh", 4},
      {"max_power_kw", "peak power", "kW", 2},
      {"max_power_mean_500ms_kw", "peak power, 500 ms mean", "kW", 2},
      {"max_battery_current_a", "peak battery current", "A", 1},
      {"min_pack_voltage_v", "lowest pack voltage", "V", 2},
      {"min_cell_voltage_v", "lowest cell voltage", "V", 3},
      {"max_battery_temp_c", "hottest cell", "°C", 2},
      {"max_motor_temp_c", "hottest motor winding", "°C", 1},
      {"max_speed_mps", "top speed", "m/s", 2},
  };
  return rows;
}

ComparedRun read_compared_run(const std::string& file) {
  const Json json = parsed(file);
  const Fields fields(file, json);
  ComparedRun run{.file = file};
  read_failure(file, fields, run);
  run.vehicle = fields.words("vehicle");
  run.course = fields.words("course");
  run.lap_start = fields.words("lap_start");
  run.trace = trace_of(file, json);
  run.cells = fields.words("cells");
  run.version = fields.words("version");
  if (!fields.at("seed").is_number_unsigned()) fields.refuse("seed", fields.at("seed"), "a whole number");
  run.seed = fields.at("seed").get<std::uint64_t>();
  run.laps_asked = fields.count("laps_asked");
  run.laps = fields.count("laps");
  if (!fields.at("course_length_m").is_null()) run.course_length_m = fields.number("course_length_m");
  for (const ComparedResult& row : compared_results()) run.results.push_back(fields.number(row.key));
  if (!fields.at("parameters").is_object()) fields.refuse("parameters", fields.at("parameters"), "keys with values");
  for (const auto& [key, value] : fields.at("parameters").items()) {
    run.parameters.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
  }
  if (!fields.at("limit_active_s").is_object()) fields.refuse("limit_active_s", fields.at("limit_active_s"), "seconds");
  const Fields limits(file, fields.at("limit_active_s"));
  for (const auto& [name, value] : fields.at("limit_active_s").items()) {
    run.limit_active_s.emplace_back(name, limits.number(name.c_str()));
  }
  if (!fields.at("lap_rows").is_array()) fields.refuse("lap_rows", fields.at("lap_rows"), "a list of laps");
  run.lap_rows = laps_of(file, fields.at("lap_rows"));
  VOLTLAP_DEMAND(run.trace.size() == trace_channels().size() && run.results.size() == compared_results().size());
  return run;
}

}  // namespace voltlap::plant
