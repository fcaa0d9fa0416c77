// SPDX-License-Identifier: Apache-2.0
#include "port/host/can_interface.hpp"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "port/host/bus_error.hpp"

namespace voltlap::port {
namespace {

std::string how_to_get_one(const std::string& interface) {
  return "As root: ip link add dev " + interface + " type vcan && ip link set " + interface +
         " up. Without root or without the kernel's module: ./voltlap with-vcan COMMAND.";
}

bool is_gone(int error) { return error == ENETDOWN || error == ENODEV || error == ENXIO; }

/// Name, kind and state of the interface, before anything is sent.
void check_interface(int socket, const std::string& interface) {
  ifreq request{};
  if (interface.empty() || interface.size() >= sizeof request.ifr_name) {
    throw BusSetupError(quoted(interface) + ": found a name of " + std::to_string(interface.size()) +
                        " characters; expected 1 to 15 characters. Give the name of an interface, such as vcan0.");
  }
  std::copy(interface.begin(), interface.end(), request.ifr_name);
  if (::ioctl(socket, SIOCGIFHWADDR, &request) != 0) {
    throw BusSetupError(quoted(interface) + ": found no such interface; expected one that exists. " +
                        how_to_get_one(interface));
  }
  if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) {
    throw BusSetupError(quoted(interface) + ": found a network interface that is no CAN interface; expected one that "
                        "is. Give another, such as vcan0.");
  }
  if (::ioctl(socket, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) == 0) {
    throw BusSetupError(quoted(interface) + ": found that it is down; expected it up. As root: ip link set " +
                        interface + " up (a real one needs its bit rate first: ip link set " + interface +
                        " type can bitrate 500000).");
  }
}

int open_socket(const std::string& interface) {
  const int socket = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (socket >= 0) return socket;
  if (errno == EPERM || errno == EACCES) {
    throw BusSetupError(quoted(interface) + ": found that CAN sockets are not permitted here (" + std::strerror(errno) +
                        "); expected leave to open one. Ask who runs this container or sandbox, or run: "
                        "./voltlap with-vcan COMMAND.");
  }
  throw BusSetupError(quoted(interface) + ": found a kernel without CAN sockets (" + std::strerror(errno) +
                      "); expected one that has them. Run the command in such a one: ./voltlap with-vcan COMMAND.");
}

}  // namespace

std::string quoted(const std::string& interface) { return "CAN interface \"" + interface + "\""; }

CanDescriptor::CanDescriptor(const std::string& interface) : socket_(open_socket(interface)) {
  try {
    check_interface(socket_, interface);
  } catch (...) {
    ::close(socket_);
    throw;
  }
}

CanDescriptor::~CanDescriptor() { ::close(socket_); }

void CanDescriptor::bind(const std::string& interface) const {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw BusSetupError(quoted(interface) + ": found that it cannot be used (" + std::strerror(errno) +
                        "); expected a CAN interface that is up. ip -details link show " + interface +
                        " says more.");
  }
}

void fail_on_bus(const std::string& interface, int error, const char* action) {
  if (is_gone(error)) throw BusDownError(quoted(interface) + " went down or was removed: " + std::strerror(error));
  if (error == ENOBUFS) {
    throw BusDownError(quoted(interface) + " took no frame for 100 ms: its queue stays full. On a real bus another "
                       "node must acknowledge; a longer queue: ip link set " + interface + " txqueuelen 1000");
  }
  throw BusDownError(quoted(interface) + ": cannot " + action + ": " + std::strerror(error));
}

}  // namespace voltlap::port
