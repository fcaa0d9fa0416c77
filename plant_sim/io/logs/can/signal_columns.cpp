// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/signal_columns.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kWaiting = 8192;  // values of a column that are written at once

void write_file(const std::string& path, const char* mode, const void* data, std::size_t size) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), mode), std::fclose);
  if (!file || std::fwrite(data, 1, size, file.get()) != size || std::fflush(file.get()) != 0) {
    throw OutputError(fmt::format("{} cannot be written: {}. Free some space there, or name another folder in TMPDIR",
                                  path, std::strerror(errno)));
  }
}

/// Names of the values, where a value is its raw one.
nlohmann::json names_of(const DbcSignal& signal) {
  if (signal.value_names.empty() || signal.scale != 1.0 || signal.offset != 0.0) return nullptr;
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [raw, name] : signal.value_names) out[fmt::format("{}", raw)] = name;
  return out;
}

}  // namespace

void SignalColumns::append(Column& column, double value) {
  column.waiting.push_back(value);
  if (column.waiting.size() >= kWaiting) flush(column);
}

void SignalColumns::flush(Column& column) {
  if (column.waiting.empty()) return;
  write_file(folder_ + "/" + column.file, "ab", column.waiting.data(), column.waiting.size() * sizeof(double));
  column.waiting.clear();
}

void SignalColumns::add(const SignalRows::Row& row) {
  VOLTLAP_DEMAND(row.group <= groups_.size());  // groups come one by one
  if (!begun_) origin_s_ = row.time_s;
  begun_ = true;
  if (row.group == groups_.size()) {
    Group& group = groups_.emplace_back();
    group.columns.push_back({fmt::format("{}.time.f64", row.group), {}});
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      group.columns.push_back({fmt::format("{}.{}.f64", row.group, k), {}});
    }
  }
  Group& group = groups_[row.group];
  VOLTLAP_DEMAND(group.columns.size() == row.values.size() + 1);
  ++group.rows;
  append(group.columns[0], row.time_s - origin_s_);
  for (std::size_t k = 0; k < row.values.size(); ++k) append(group.columns[k + 1], row.values[k]);
}

void SignalColumns::finish(const std::vector<SignalGroup>& groups, const std::string& source) {
  nlohmann::json manifest{{"origin_s", origin_s_}, {"source", source}, {"groups", nlohmann::json::array()}};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (Column& column : groups_[g].columns) flush(column);
    nlohmann::json columns = nlohmann::json::array();
    for (std::size_t k = 0; k < groups[g].signals.size(); ++k) {
      const DbcSignal& signal = groups[g].signal(k);
      columns.push_back({{"name", signal.name},
                         {"unit", signal.unit},
                         {"comment", ""},
                         {"file", groups_[g].columns[k + 1].file},
                         {"choices", names_of(signal)}});
    }
    manifest["groups"].push_back({{"name", groups[g].name},
                                  {"bus", groups[g].bus},
                                  {"id", groups[g].id & ~RecordedFrame::kExtendedFlag},
                                  {"rows", groups_[g].rows},
                                  {"time", groups_[g].columns[0].file},
                                  {"columns", columns}});
  }
  const std::string text = manifest.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
  write_file(folder_ + "/manifest.json", "wb", text.data(), text.size());
}

}  // namespace voltlap::plant
