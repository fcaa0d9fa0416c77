// SPDX-License-Identifier: Apache-2.0
#include "apps/program.hpp"

namespace voltlap::plant {

void introduce(CLI::App& app) {
  app.name("voltlap");
  app.description("Voltlap: an electric race car, its battery and its control firmware on one CAN bus.");
  app.set_version_flag("--version", "voltlap " VOLTLAP_VERSION);
  app.require_subcommand(1);
  app.failure_message(usage_message);
}

DataFolder shipped_data() { return DataFolder(VOLTLAP_DATA_FOLDER); }

}  // namespace voltlap::plant
