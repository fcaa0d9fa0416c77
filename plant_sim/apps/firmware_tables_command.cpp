// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_tables_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/firmware_header.hpp"
#include "apps/flag_checks.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {

FirmwareTablesCommand::FirmwareTablesCommand(CLI::App& app)
    : command_(
          app.add_subcommand("firmware-tables", "A cell file as the C++ header that a BMS image is built with")) {
  command_->add_option("cell", cell_, "Cell file: name or path")->required();
  car_.add_vehicle(*command_);
  add_output_file(*command_, "--out", out_, "Write the header");
  command_->footer(
      "Cells in series and in parallel, thermistors and limits are the vehicle's; the header defines\n"
      "voltlap::bms::kPackConfig, which the BMS runs exactly as it does in the simulated car.\n"
      "Example: voltlap firmware-tables cell.toml --set battery.cells_in_parallel=2 --out pack_config.hpp");
}

int FirmwareTablesCommand::run(const DataFolder& data) {
  (void)load_cell(data, cell_, "cell");  // its own errors first
  std::string command = fmt::format("voltlap firmware-tables {}", std::filesystem::path(cell_).filename().string());
  if (car_.vehicle != "vtm16e") command += " --vehicle " + car_.vehicle;
  for (const std::string& setting : car_.settings) command += " --set " + setting;
  const std::string path = data.find("cells", cell_, "cell");
  car_.settings.insert(car_.settings.begin(), "battery.cell=" + std::filesystem::absolute(path).string());
  const LoadedVehicle loaded = car_.load_car(data);
  const VehicleParameters& car = loaded.parameters;
  const bms::Config config = bms_config(car, loaded.origin);
  const TableRounding rounding = table_rounding(car, config);
  const BranchReduction reduction = two_branch_tables(car, config);
  std::optional<AtomicFile> file;
  if (!out_.empty()) file.emplace(out_);
  fmt::print(summary_stream({out_}), "{}: {} in series, {:.3f} Ah, {:g} to {:g} V a cell\n{}{}", car.cell.name,
             config.cells_in_series, 1e-3 * config.capacity_mah, 1e-4 * config.cell_voltage_min.raw(),
             1e-4 * config.cell_voltage_max.raw(), rounding_text(config, rounding), branches_text(car, reduction));
  if (file) {
    file->write(firmware_header(car, config, rounding, reduction, {VOLTLAP_VERSION, command + " --out FILE"}));
    file->commit();
  } else {
    fmt::print("nothing was written; give --out FILE.hpp for the header\n");
  }
  return kExitOk;
}

}  // namespace voltlap::plant
