// SPDX-License-Identifier: Apache-2.0
// What the frames of a run cost by themselves: three processes send them in turn, batch by batch, and each waits until
// it has counted those of the others. No lockstep frame, no car, no firmware.
//   bare_exchange INTERFACE LOG       LOG: candump file of a run; prints the seconds of the exchange
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "can_dbc/tables.hpp"

namespace {

using namespace voltlap;

constexpr std::size_t kBatch = 64;
constexpr std::size_t kNodes = 3;  // plant, BMS, master

struct Tick {
  std::array<std::vector<can_frame>, kNodes> sent;
};

std::size_t node_of(std::uint32_t id) { return static_cast<std::size_t>(can::sender_of(id)) - 1; }

std::vector<Tick> read_log(const char* path) {
  std::vector<Tick> ticks;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string time, interface, text;
    words >> time >> interface >> text;
    const auto tick = static_cast<std::size_t>(std::stod(time.substr(1)) * 100.0 + 0.5);
    can_frame frame{};
    frame.can_id = static_cast<canid_t>(std::stoul(text.substr(0, text.find('#')), nullptr, 16));
    const std::string data = text.substr(text.find('#') + 1);
    frame.len = static_cast<std::uint8_t>(data.size() / 2);
    for (std::size_t i = 0; i < frame.len; ++i) {
      frame.data[i] = static_cast<std::uint8_t>(std::stoul(data.substr(2 * i, 2), nullptr, 16));
    }
    ticks.resize(std::max(ticks.size(), tick + 1));
    ticks[tick].sent[node_of(frame.can_id)].push_back(frame);
  }
  return ticks;
}

/// Identifiers that a node listens to; the plant hears everything, its own frames too.
template <std::size_t N>
std::vector<can_filter> filters_of(const can::MessageRow (&rows)[N]) {
  std::vector<can_filter> out;
  for (const can::MessageRow& row : rows) out.push_back({row.id, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG});
  return out;
}

class Node {
 public:
  Node(const char* interface, const std::vector<can_filter>& filters) : socket_(::socket(PF_CAN, SOCK_RAW, CAN_RAW)) {
    const int own = filters.front().can_mask == 0 ? 1 : 0, buffer = 4 << 20;
    ::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &own, sizeof own);
    const auto bytes = static_cast<socklen_t>(filters.size() * sizeof(can_filter));
    ::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), bytes);
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(interface));
    if (::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      std::perror(interface);
      std::exit(2);
    }
    for (std::size_t i = 0; i < kBatch; ++i) {
      vectors_[i] = {&frames_[i], sizeof(can_frame)};
      headers_[i].msg_hdr.msg_iov = &vectors_[i];
      headers_[i].msg_hdr.msg_iovlen = 1;
    }
  }
  void send(const std::vector<can_frame>& frames) {
    std::copy(frames.begin(), frames.end(), frames_.begin());
    for (std::size_t sent = 0; sent < frames.size();) {
      const int count = ::sendmmsg(socket_, &headers_[sent], static_cast<unsigned>(frames.size() - sent), 0);
      if (count < 0) std::exit(3);
      sent += static_cast<std::size_t>(count);
    }
  }
  void receive(std::size_t count) {
    while (waiting_ < count) {
      const int got = ::recvmmsg(socket_, headers_.data(), kBatch, MSG_WAITFORONE, nullptr);
      if (got < 0) std::exit(4);
      waiting_ += static_cast<std::size_t>(got);
    }
    waiting_ -= count;
  }

 private:
  int socket_;
  std::array<can_frame, kBatch> frames_{};
  std::array<iovec, kBatch> vectors_{};
  std::array<mmsghdr, kBatch> headers_{};
  std::size_t waiting_ = 0;  ///< read ahead of their turn
};

std::size_t heard(const std::vector<can_frame>& frames, const std::vector<can_filter>& filters) {
  std::size_t count = 0;
  for (const can_frame& f : frames) {
    for (const can_filter& filter : filters) {
      if ((f.can_id & filter.can_mask) == (filter.can_id & filter.can_mask)) ++count;
    }
  }
  return count;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::vector<Tick> ticks = read_log(argv[2]);
  const std::array<std::vector<can_filter>, kNodes> filters = {std::vector<can_filter>{{0, 0}}, filters_of(can::kBmsRx),
                                                               filters_of(can::kMasterRx)};
  // Frames that a node waits for before its turn: those of the others since its last one.
  std::array<std::vector<std::size_t>, kNodes> awaited;
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    const auto& [plant, bms, master] = ticks[n].sent;
    awaited[1].push_back(heard(plant, filters[1]) + (n > 0 ? heard(ticks[n - 1].sent[2], filters[1]) : 0));
    awaited[2].push_back(heard(plant, filters[2]) + heard(bms, filters[2]));
    awaited[0].push_back(plant.size() + bms.size() + master.size());
  }
  std::array<Node, kNodes> nodes = {Node(argv[1], filters[0]), Node(argv[1], filters[1]), Node(argv[1], filters[2])};
  std::array<pid_t, kNodes> children{};
  for (std::size_t node = 1; node < kNodes; ++node) {
    children[node] = ::fork();
    if (children[node] != 0) continue;
    for (std::size_t n = 0; n < ticks.size(); ++n) {
      nodes[node].receive(awaited[node][n]);
      nodes[node].send(ticks[n].sent[node]);
    }
    ::_exit(0);
  }
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    nodes[0].send(ticks[n].sent[0]);
    nodes[0].receive(awaited[0][n]);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (std::size_t node = 1; node < kNodes; ++node) {
    int status = 0;
    ::waitpid(children[node], &status, 0);
    if (status != 0) return 5;
  }
  std::printf("%zu ticks %.6f s\n", ticks.size(), seconds);
  return 0;
}
