// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_tables_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/firmware_header.hpp"
#include "apps/flag_checks.hpp"
#include "apps/master_header.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {

FirmwareTablesCommand::FirmwareTablesCommand(CLI::App& app)
    : command_(app.add_subcommand("firmware-tables",
                                  "A car with its cell as the C++ headers that an image is built with")) {
  command_->add_option("cell", cell_, "Cell file: name or path; default: the vehicle's own");
  car_.add_vehicle(*command_);
  add_output_file(*command_, "--out", out_, "Write the BMS's header");
  add_output_file(*command_, "--master-out", master_out_, "Write the master controller's header");
  command_->footer(
      "Cells in series and in parallel, thermistors and limits are the vehicle's; the headers define\n"
      "voltlap::bms::kPackConfig and voltlap::master::kMasterConfig, which the firmware runs exactly as it does in\n"
      "the simulated car. ./voltlap image --vehicle CAR makes both and builds with them.\n"
      "Example: voltlap firmware-tables cell.toml --set battery.cells_in_parallel=2 --out pack_config.hpp");
}

std::string FirmwareTablesCommand::command_line() const {
  std::string out = "voltlap firmware-tables";
  if (!cell_.empty()) out += " " + std::filesystem::path(cell_).filename().string();
  if (car_.vehicle != "vtm16e") out += " --vehicle " + std::filesystem::path(car_.vehicle).filename().string();
  for (const std::string& setting : car_.settings) out += " --set " + setting;
  return out;
}

int FirmwareTablesCommand::run(const DataFolder& data) {
  refuse_shared_files({{"--out", out_}, {"--master-out", master_out_}});
  const std::string command = command_line();
  if (!cell_.empty()) {
    (void)load_cell(data, cell_, "cell");  // its own errors first
    const std::string path = data.find("cells", cell_, "cell");
    car_.settings.insert(car_.settings.begin(), "battery.cell=" + std::filesystem::absolute(path).string());
  }
  const LoadedVehicle loaded = car_.load_car(data);
  const VehicleParameters& car = loaded.parameters;
  const bms::Config config = bms_config(car, loaded.origin);
  const master::Config master = master_config(car, loaded.origin);
  const TableRounding rounding = table_rounding(car, config);
  const BranchReduction reduction = two_branch_tables(car, config);
  std::optional<AtomicFile> file, master_file;
  if (!out_.empty()) file.emplace(out_);
  if (!master_out_.empty()) master_file.emplace(master_out_);
  fmt::print(summary_stream({out_, master_out_}), "{}: {} in series, {:.3f} Ah, {:g} to {:g} V a cell\n{}{}",
             car.cell.name, config.cells_in_series, 1e-3 * config.capacity_mah, 1e-4 * config.cell_voltage_min.raw(),
             1e-4 * config.cell_voltage_max.raw(), rounding_text(config, rounding), branches_text(car, reduction));
  if (file) file->write(firmware_header(car, config, rounding, reduction, {VOLTLAP_VERSION, command + " --out FILE"}));
  if (master_file) {
    master_file->write(master_header(car.name, master, {VOLTLAP_VERSION, command + " --master-out FILE"}));
  }
  if (file) file->commit();
  if (master_file) master_file->commit();
  if (!file && !master_file) fmt::print("nothing was written; give --out FILE.hpp for the header\n");
  return kExitOk;
}

}  // namespace voltlap::plant
