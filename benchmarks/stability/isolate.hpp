#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "benchmarks/stability/case.hpp"

namespace weft::stability {

/// Folder for files of the cases that this process runs. It is there until the process's parent, if
/// that is run_apart() or the owner of the Child, has seen its end.
std::filesystem::path scratch_folder();

/// A case in a process of its own, so that a crash or a run without end is a verdict too.
class Child {
 public:
  /// Starts it.
  /// @pre this process has one thread
  /// @throws std::system_error if there can be no process
  Child(const Case& c, Setup setup, double limit);
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  const Case& what() const { return case_; }
  const Setup& setup() const { return setup_; }

  /// Reads what is there, and ends the process if its time is over.
  /// @return whether verdict() is there
  bool poll();

  /// File that can be read from once there is something for poll() to do; -1 once done.
  int descriptor() const { return descriptor_; }

  Verdict verdict() const;
  double seconds() const { return seconds_; }

 private:
  void reap();

  const Case& case_;
  Setup setup_;
  double limit_;
  std::chrono::steady_clock::time_point start_;
  int process_ = -1;
  int descriptor_ = -1;
  bool timed_out_ = false;
  int status_ = 0;
  double seconds_ = 0;
  std::string text_;
};

/// Runs a case in a process of its own and waits for it.
/// @param limit [s]
Verdict run_apart(const Case& c, const Setup& setup, double limit);

}  // namespace weft::stability
