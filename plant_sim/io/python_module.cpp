// SPDX-License-Identifier: Apache-2.0
#include "io/python_module.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {
namespace {

constexpr int kExitInput = 2, kExitPackageMissing = 3, kExitBrokeOff = 3, kExitNotFound = 127;
constexpr std::size_t kMostWords = 4000;  // of standard error in a message
constexpr std::string_view kNoModule = "No module named ";

/// Both ends of a pipe; neither is inherited.
struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe to a Python module can be made");
    read = ends[0];
    write = ends[1];
  }
  ~Pipe() {
    close_end(read);
    close_end(write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
  int read = -1, write = -1;
};

std::string project_folder() {
  return std::filesystem::path(VOLTLAP_PYTHON_FOLDER).parent_path().parent_path().string();
}

std::string how_to_install() {
  const std::string folder = project_folder();
  return fmt::format("Install it: python3 -m venv {0}/build/venv && {0}/build/venv/bin/pip install -r "
                     "{0}/toolchain/requirements/run.txt; or name another Python in VOLTLAP_PYTHON",
                     folder);
}

/// The environment with the modules' folder in front of Python's own. A module of the same name in the user's folder
/// does not come in between.
std::vector<std::string> environment() {
  std::string path = VOLTLAP_PYTHON_FOLDER;
  if (const char* more = std::getenv("PYTHONPATH"); more != nullptr && *more != '\0') path += fmt::format(":{}", more);
  std::vector<std::string> out{"PYTHONPATH=" + path, "PYTHONSAFEPATH=1", "PYTHONUTF8=1"};
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const auto ours = [&](std::string_view name) { return text.starts_with(name); };
    if (!ours("PYTHONPATH=") && !ours("PYTHONSAFEPATH=") && !ours("PYTHONUTF8=")) out.emplace_back(text);
  }
  return out;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (std::string& text : texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

[[noreturn]] void fail_to_start(const std::string& program) {
  throw InputError(program, "no Python that can be started", "a Python 3 with the packages of run.txt",
                   how_to_install());
}

pid_t start(const std::string& program, std::vector<std::string> command, const std::string& in, const Pipe& out,
            const Pipe& errors) {
  std::vector<std::string> surroundings = environment();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, in.empty() ? "/dev/null" : in.c_str(), O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.write, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors.write, STDERR_FILENO);
  // The program may ignore or block signals; the module has them as usual, so that Ctrl-C ends it, too.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t usual, none;
  ::sigemptyset(&none);
  ::sigemptyset(&usual);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) ::sigaddset(&usual, number);
  posix_spawnattr_setsigdefault(&attributes, &usual);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  pid_t pid = -1;
  const int error = ::posix_spawnp(&pid, program.c_str(), &actions, &attributes, pointers(command).data(),
                                   pointers(surroundings).data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) fail_to_start(program);
  return pid;
}

using Sink = std::function<void(std::string_view)>;

/// Reads both pipes to their ends, side by side, so that neither fills up.
void drain(Pipe& out, Pipe& errors, const Sink& sink, std::string& words) {
  std::array<char, 1U << 16> buffer;
  std::array<pollfd, 2> ends{pollfd{out.read, POLLIN, 0}, pollfd{errors.read, POLLIN, 0}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) break;
    for (pollfd& end : ends) {
      if (end.fd < 0 || end.revents == 0) continue;
      const ssize_t count = ::read(end.fd, buffer.data(), buffer.size());
      if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (count <= 0) {
        end.fd = -1;
        continue;
      }
      const std::string_view text(buffer.data(), static_cast<std::size_t>(count));
      if (&end == &ends[0]) {
        sink(text);
      } else if (words.size() < kMostWords) {
        words += text;
      }
    }
  }
}

int ended(pid_t pid) {
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) throw std::runtime_error("a Python module cannot be waited for");
  }
  return status;
}

/// The process, ended in any case.
class Running {
 public:
  explicit Running(pid_t pid) : pid_(pid) { VOLTLAP_DEMAND(pid > 0); }
  ~Running() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  int wait() {
    const int status = ended(pid_);
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_;
};

[[noreturn]] void refuse(const std::string& module, int status, std::string words) {
  while (!words.empty() && (words.back() == '\n' || words.back() == ' ')) words.pop_back();
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    // Ctrl-C that only the module saw ends this program in the same way.
    if (number == SIGINT || number == SIGTERM) ::raise(number);
    throw std::runtime_error(fmt::format("{} was ended by signal {} ({})", module, number, ::strsignal(number)));
  }
  const int code = WEXITSTATUS(status);
  if (code == kExitInput && !words.empty()) throw InputError(words);
  if (code == kExitNotFound) fail_to_start(python_program());
  if (const std::size_t at = words.rfind(kNoModule);
      at != std::string::npos && (code == kExitPackageMissing || code == 1)) {
    const std::string name = words.substr(at + kNoModule.size());
    throw InputError(python_program(), "no Python package " + name.substr(0, name.find('\n')),
                     "the packages of toolchain/requirements/run.txt", how_to_install());
  }
  throw std::runtime_error(fmt::format("{} ended with exit code {}: {}", module, code, words));
}

struct End {
  int status;
  std::string words;
};

End run_to_end(const std::string& module, const std::vector<std::string>& arguments, const std::string& in,
               const Sink& sink) {
  VOLTLAP_DEMAND(!module.empty());
  const std::string program = python_program();
  std::vector<std::string> command{program, "-m", module};
  command.insert(command.end(), arguments.begin(), arguments.end());
  Pipe out, errors;
  Running process(start(program, std::move(command), in, out, errors));
  Pipe::close_end(out.write);
  Pipe::close_end(errors.write);
  std::string words;
  drain(out, errors, sink, words);
  const int status = process.wait();
  return {status, std::move(words)};
}

void run(const std::string& module, const std::vector<std::string>& arguments, const Sink& sink) {
  End end = run_to_end(module, arguments, "", sink);
  if (end.status != 0) refuse(module, end.status, std::move(end.words));
}

}  // namespace

std::string python_program() {
  if (const char* named = std::getenv("VOLTLAP_PYTHON"); named != nullptr && *named != '\0') return named;
  for (const std::string& path : {std::string(VOLTLAP_PYTHON_PROGRAM), project_folder() + "/build/venv/bin/python"}) {
    if (!path.empty() && ::access(path.c_str(), X_OK) == 0) return path;
  }
  return "python3";
}

std::string run_python_module(const std::string& module, const std::vector<std::string>& arguments) {
  std::string out;
  run(module, arguments, [&](std::string_view text) { out += text; });
  return out;
}

void run_python_module_into(const std::string& path, const std::string& module,
                            const std::vector<std::string>& arguments) {
  AtomicFile file(path);
  run(module, arguments, [&](std::string_view text) { file.write(text); });
  file.commit();
}

PythonReport run_recording_module(const std::string& module, const std::vector<std::string>& arguments,
                                  const PythonStreams& streams) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(nullptr, std::fclose);
  if (!streams.out.empty()) {
    out.reset(std::fopen(streams.out.c_str(), "wb"));
    if (!out) throw OutputError(fmt::format("{} cannot be written: {}", streams.out, std::strerror(errno)));
  }
  bool whole = true;
  End end = run_to_end(module, arguments, streams.in, [&](std::string_view text) {
    if (out) whole = whole && std::fwrite(text.data(), 1, text.size(), out.get()) == text.size();
  });
  if (out) whole = std::fclose(out.release()) == 0 && whole;
  if (!whole) throw OutputError(fmt::format("{} cannot be written: the disk is full", streams.out));
  const bool broke_off = WIFEXITED(end.status) && WEXITSTATUS(end.status) == kExitBrokeOff;
  if (end.status != 0 && !broke_off) refuse(module, end.status, std::move(end.words));
  return {broke_off, std::move(end.words)};
}

}  // namespace voltlap::plant
