// SPDX-License-Identifier: Apache-2.0
#include "io/play/play_socket.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>

#include "core/demand.hpp"
#include "port/host/bus_error.hpp"
#include "port/host/send_all.hpp"

namespace voltlap::plant {
namespace {

static_assert(RecordedFrame::kMostBytes == CANFD_MAX_DLEN);

bool takes_flexible(int socket, const std::string& interface) {
  ifreq request{};
  std::copy_n(interface.begin(), std::min(interface.size(), sizeof request.ifr_name - 1), request.ifr_name);
  const int on = 1;
  return ::ioctl(socket, SIOCGIFMTU, &request) == 0 && request.ifr_mtu >= static_cast<int>(CANFD_MTU) &&
         ::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) == 0;
}

}  // namespace

PlaySocket::PlaySocket(std::string interface, std::size_t flexible)
    : interface_(std::move(interface)), descriptor_(interface_) {
  if (flexible > 0 && !takes_flexible(descriptor_.get(), interface_)) {
    throw port::BusSetupError(fmt::format(
        "{}: found that it takes no CAN FD frames, and {} of those to be played are; expected one that does. A "
        "virtual one, as root, while it is down: ip link set {} mtu 72 (a real one: fd on). The others alone: choose "
        "with --id.",
        port::quoted(interface_), flexible, interface_));
  }
  ::setsockopt(descriptor_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);  // nothing is read
  descriptor_.bind(interface_);
}

void PlaySocket::send(const PlayFrame& frame) {
  VOLTLAP_DEMAND(frame.length <= (frame.flexible ? CANFD_MAX_DLEN : CAN_MAX_DLEN));
  canfd_frame raw{};  // a classic frame is its beginning
  raw.can_id = frame.id | (frame.remote ? CAN_RTR_FLAG : 0U);
  raw.len = frame.length;
  const bool flexible = frame.flexible && !frame.remote;
  if (flexible) raw.flags = frame.flags;
  if (!frame.remote) std::copy_n(frame.data, frame.length, raw.data);
  const std::size_t size = flexible ? CANFD_MTU : CAN_MTU;
  const port::SendOutcome outcome = port::send_all(
      1, [&](unsigned) { return ::send(descriptor_.get(), &raw, size, MSG_DONTWAIT) < 0 ? -1 : 1; },
      [] {
        const timespec pause{0, port::kSendRetryWait_us * 1000};
        ::nanosleep(&pause, nullptr);
      });
  retries_ += static_cast<std::uint64_t>(outcome.retries);
  if (outcome.error != 0) port::fail_on_bus(interface_, outcome.error, "send");
}

}  // namespace voltlap::plant
