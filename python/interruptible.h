// SPDX-License-Identifier: BSD-3-Clause
// Long work for Python: without the interpreter's lock, so that other threads of Python go on, and
// so that Ctrl-C ends it. The work runs in a thread of its own while the calling thread looks for
// signals. Where the work builds a graph or tells its progress it asks whether it shall go on.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>

namespace magimu::python {

// Not a std::exception: nothing on the way takes it for a failure of numbers or input.
struct Interrupted {};

class Interruption {
 public:
  void request() { requested_ = true; }
  // For CalibrationOptions::also and the like, which every graph is given to.
  void stop_if_requested() const {
    if (requested_) throw Interrupted();
  }

 private:
  std::atomic<bool> requested_ = false;
};

// f(const Interruption&) -> a value. Called with the lock held; throws what f throws, or
// KeyboardInterrupt.
template <class F>
auto interruptible(const F& f) -> std::invoke_result_t<const F&, const Interruption&> {
  using namespace std::chrono_literals;
  namespace py = pybind11;
  std::optional<std::invoke_result_t<const F&, const Interruption&>> result;
  std::exception_ptr failure;
  std::optional<py::error_already_set> signal;  // what Python's handler of a signal raised
  Interruption interruption;
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  {
    const py::gil_scoped_release release;
    std::thread worker([&] {
      try {
        result.emplace(f(interruption));
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      done = true;
      ended.notify_one();
    });
    for (;;) {
      {
        std::unique_lock lock(mutex);
        if (ended.wait_for(lock, 100ms, [&] { return done; })) break;
      }
      if (signal) continue;
      const py::gil_scoped_acquire acquire;
      if (PyErr_CheckSignals() == 0) continue;
      signal.emplace();
      interruption.request();
    }
    worker.join();
  }
  if (signal) throw py::error_already_set(*signal);
  if (failure) std::rethrow_exception(failure);
  return std::move(*result);
}

}  // namespace magimu::python
