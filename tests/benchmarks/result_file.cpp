// SPDX-License-Identifier: Apache-2.0
#include "result_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "comparison.hpp"
#include "core/errors.hpp"
#include "quantities.hpp"

namespace voltlap::benchmarks {
namespace {

using Json = nlohmann::ordered_json;
using plant::InputError;

// No block of commands: the documents' commands are run by the tests, and this one takes its time.
constexpr const char* kDocument = R"(# How fast it is

Made by `./voltlap benchmark --markdown docs/benchmark.md`; another machine gives other numbers. Times are processor
time of one core. A second of simulation is a second of the race; for the lap solver the last column is lap time over
the time to solve it.

To see whether a change costs time: `./voltlap benchmark --json before.json`, change, then
`./voltlap benchmark --compare before.json`. The comparison is in units of a fixed reference kernel that runs every few
milliseconds of the measurement, so that a busy or slower machine does not count. A row counts as slower when the whole
interval of the ratio lies above {:.2f}; then the exit code is 1.

| row | one operation | time | simulated seconds per second |
|---|---|---:|---:|
)";
constexpr const char* kMakeOne = "Give a file that benchmark --json has written";

/// A field of a JSON object that must be there and have the type of `Value`.
template <class Value>
Value field(const std::string& place, const Json& object, const char* name) {
  const auto found = object.find(name);
  bool fits = found != object.end();
  if constexpr (std::is_same_v<Value, std::string>) fits = fits && found->is_string();
  else fits = fits && found->is_number();
  if (!fits) {
    throw InputError(fmt::format("{}, {}", place, name), found == object.end() ? "nothing" : found->dump(),
                     std::is_same_v<Value, std::string> ? "a text" : "a number", kMakeOne);
  }
  return found->template get<Value>();
}

double positive(const std::string& place, const Json& object, const char* name) {
  const double value = field<double>(place, object, name);
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InputError(fmt::format("{}, {}", place, name), fmt::format("{}", value), "a number above 0", kMakeOne);
  }
  return value;
}

const Json& part(const std::string& path, const Json& whole, const char* name, Json::value_t type) {
  const auto found = whole.find(name);
  if (found == whole.end() || found->type() != type) {
    throw InputError(path, fmt::format("no \"{}\"", name), "a measurement", kMakeOne);
  }
  return *found;
}

Row row_of(const std::string& path, const Json& json) {
  const std::string list = fmt::format("{}, benchmarks", path);
  if (!json.is_object()) throw InputError(list, json.dump(), "an object for each row", kMakeOne);
  const std::string name = field<std::string>(list, json, "name"), place = fmt::format("{}, {}", path, name);
  return {.name = name,
          .operation = field<std::string>(place, json, "operation"),
          .repetitions = field<int>(place, json, "repetitions"),
          .sim_s_per_s = positive(place, json, "sim_s_per_s"),
          .estimate = {.ns = positive(place, json, "ns"),
                       .relative = positive(place, json, "relative"),
                       .low = positive(place, json, "relative_low"),
                       .high = positive(place, json, "relative_high"),
                       .spread = field<double>(place, json, "spread")}};
}

Json json_of(const Machine& machine) {
  return {{"cpu", machine.cpu},           {"cores", machine.cores},           {"governor", machine.governor},
          {"frequency", machine.frequency}, {"compiler", machine.compiler},     {"build_type", machine.build_type},
          {"flags", machine.flags},       {"version", machine.version}};
}

}  // namespace

std::string to_json(const Measurement& measurement) {
  Json rows = Json::array();
  for (const Row& row : measurement.rows) {
    rows.push_back({{"name", row.name},
                    {"operation", row.operation},
                    {"ns", row.estimate.ns},
                    {"spread", row.estimate.spread},
                    {"sim_s_per_s", row.sim_s_per_s},
                    {"relative", row.estimate.relative},
                    {"relative_low", row.estimate.low},
                    {"relative_high", row.estimate.high},
                    {"repetitions", row.repetitions}});
  }
  const Json json = {
      {"machine", json_of(measurement.machine)}, {"reference_ns", measurement.reference_ns}, {"benchmarks", rows}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Measurement read_json(const std::string& path) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  std::ifstream in(path);
  if (!in || folder) {
    throw InputError("--compare " + path, folder ? "a folder" : std::strerror(errno), "an earlier measurement",
                     kMakeOne);
  }
  const Json json = Json::parse(std::string(std::istreambuf_iterator<char>(in), {}), nullptr, false);
  if (!json.is_object()) throw InputError(path, "no JSON object", "a measurement", kMakeOne);
  const Json& machine = part(path, json, "machine", Json::value_t::object);
  const std::string place = fmt::format("{}, machine", path);
  const auto text = [&](const char* name) { return field<std::string>(place, machine, name); };
  Measurement out{.machine = {text("cpu"), field<int>(place, machine, "cores"), text("governor"), text("frequency"),
                              text("compiler"), text("build_type"), text("flags"), text("version")},
                  .reference_ns = positive(path, json, "reference_ns"),
                  .rows = {}};
  for (const Json& row : part(path, json, "benchmarks", Json::value_t::array)) out.rows.push_back(row_of(path, row));
  return out;
}

std::string to_markdown(const Measurement& measurement) {
  const Machine& m = measurement.machine;
  std::string out = fmt::format(kDocument, kThreshold);
  for (const Row& row : measurement.rows) {
    out += fmt::format("| `{}` | {} | {} | {} |\n", row.name, row.operation, time_text(row.estimate.ns),
                       factor_text(row.sim_s_per_s));
  }
  return out + fmt::format("\nvoltlap {} on {}, {} cores, {}; {}, {} ({}). Reference kernel: {}.\n", m.version, m.cpu,
                           m.cores, m.frequency, m.compiler, m.build_type, m.flags,
                           time_text(measurement.reference_ns));
}

}  // namespace voltlap::benchmarks
