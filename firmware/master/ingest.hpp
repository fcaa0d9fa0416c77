// SPDX-License-Identifier: Apache-2.0
// Frames to samples: only frames that the rx monitor accepts change a sample; samples age by the timeouts of the DBC.
#pragma once
#include "base/can_frame.hpp"
#include "can_dbc/tables.hpp"
#include "codec/rx_monitor.hpp"
#include "master/inverter/inverter.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct Receiver {
  codec::RxMonitor<can::kMasterRx> rx{};
  InverterLink inverter{};
  Input input{};  ///< computed by ingest
};

void ingest(Instant now, FrameView frames, Receiver& receiver);

}  // namespace voltlap::master
