// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/campaign_files.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <iterator>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "learn/bench/campaign_index.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kIndexName = "campaign.json";

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw OutputError(
        fmt::format("--out {}: this folder cannot be made: {}. Expected a folder, or a path where one may be "
                    "made. Choose another path.",
                    folder, error ? error.message() : "a file of this name is there"));
  }
}

}  // namespace

CampaignFiles::CampaignFiles(const Campaign& campaign, CampaignPaths paths)
    : campaign_(campaign), paths_(std::move(paths)) {
  if (!paths_.folder.empty()) make_folder(paths_.folder);
  if (paths_.truth.empty()) return;
  truth_.emplace(paths_.truth);
  truth_->write(fmt::format("# voltlap {} bench-test: truth of plan {}, cell {}, seed {}\ntest,time_s,current_a",
                            VOLTLAP_VERSION, campaign.plan().name, campaign.cell().name, campaign.seed()));
  for (int n = 1; n <= campaign.plan().cells.count; ++n) {
    truth_->write(fmt::format(",cell_{0}_voltage_v,cell_{0}_soc,cell_{0}_temperature_c", n));
  }
  truth_->write("\n");
}

void CampaignFiles::add(const BenchRecord& record) {
  TestResult result{summary_of(record), record.end_cell, {}, {}, {}, {}};
  for (std::size_t cell = 0; cell < record.cells.size(); ++cell) {
    result.capacity_ah.push_back(record.cells[cell].capacity_ah);
    result.resistance_scale.push_back(record.cells[cell].variation.resistance_scale);
    result.initial_soc.push_back(record.cells[cell].initial_soc);
    if (paths_.folder.empty()) continue;
    result.files.push_back(fmt::format("{}_cell{}.csv{}", record.test.name, cell + 1, paths_.gzip ? ".gz" : ""));
    write_table(record, cell, result.files.back());
  }
  if (truth_) write_truth(record);
  results_.push_back(std::move(result));
}

void CampaignFiles::write_table(const BenchRecord& record, std::size_t cell, const std::string& name) const {
  VOLTLAP_DEMAND(cell < record.cells.size() && record.cells[cell].voltage_v.size() == record.time_s.size());
  VOLTLAP_DEMAND(record.ambient_c.size() == record.time_s.size());
  AtomicFile file(paths_.folder + "/" + name);
  file.write(
      fmt::format("# voltlap {} bench-test: plan {}, test {}, cell {} of {}, seed {}, {}\n"
                  "time_s,current_a,voltage_v,temperature_c,ambient_c\n",
                  VOLTLAP_VERSION, campaign_.plan().name, record.test.name, cell + 1, record.cells.size(),
                  campaign_.seed(), record.test.load));
  const CellRecord& of = record.cells[cell];
  fmt::memory_buffer line;
  for (std::size_t row = 0; row < record.time_s.size(); ++row) {
    line.clear();
    fmt::format_to(std::back_inserter(line), "{},{:.4f},{:.6f},{:.3f},{:.3f}\n", record.time_s[row],
                   record.current_a[row], of.voltage_v[row], of.temperature_c[row], record.ambient_c[row]);
    file.write({line.data(), line.size()});
  }
  file.commit();
}

void CampaignFiles::write_truth(const BenchRecord& record) {
  fmt::memory_buffer line;
  for (std::size_t row = 0; row < record.time_s.size(); ++row) {
    line.clear();
    auto out = std::back_inserter(line);
    fmt::format_to(out, "{},{},{:.6f}", record.test.name, record.time_s[row], record.true_current_a[row]);
    for (const CellRecord& cell : record.cells) {
      fmt::format_to(out, ",{:.7f},{:.8f},{:.4f}", cell.true_voltage_v[row], cell.true_soc[row],
                     cell.true_temperature_c[row]);
    }
    line.push_back('\n');
    truth_->write({line.data(), line.size()});
  }
}

std::string CampaignFiles::index(const Forecast& forecast, const std::vector<std::string>& settings) const {
  return campaign_index(campaign_, forecast, results_, settings, truth_.has_value());
}

void CampaignFiles::commit(const std::string& index) {
  if (truth_) truth_->commit();
  if (paths_.folder.empty()) return;
  AtomicFile file(paths_.folder + "/" + kIndexName);
  file.write(index);
  file.commit();
}

}  // namespace voltlap::plant
