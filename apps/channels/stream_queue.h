// SPDX-License-Identifier: BSD-3-Clause
// The queue between the thread that reads a stream and the one that uses it. Bounded in bytes; what
// has no bytes always finds room. Internal to stream_source.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <utility>

#include "apps/channels/stream_source.h"

namespace magimu::apps {

class ArrivalQueue {
 public:
  // room: called, by the thread that takes, when a reader that was refused may go on.
  ArrivalQueue(std::size_t capacity, std::function<void()> room)
      : capacity_(capacity), room_(std::move(room)) {}

  void push(Arrival arrival) {
    {
      const std::lock_guard lock(mutex_);
      bytes_ += arrival.bytes.size();
      arrivals_.push_back(std::move(arrival));
    }
    filled_.notify_one();
  }

  // False: full. With `call_later` room() is called as soon as half of it is free.
  bool has_room(bool call_later) {
    const std::lock_guard lock(mutex_);
    if (bytes_ < capacity_) return true;
    call_room_ = call_later;
    return false;
  }

  Arrival pop(std::chrono::milliseconds wait) {
    std::unique_lock lock(mutex_);
    if (!filled_.wait_for(lock, wait, [this] { return !arrivals_.empty(); })) return {};
    Arrival arrival = std::move(arrivals_.front());
    arrivals_.pop_front();
    bytes_ -= arrival.bytes.size();
    const bool call = call_room_ && bytes_ <= capacity_ / 2;
    if (call) call_room_ = false;
    lock.unlock();
    if (call) room_();
    return arrival;
  }

 private:
  std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Arrival> arrivals_;
  std::size_t bytes_ = 0;
  const std::size_t capacity_;
  bool call_room_ = false;
  std::function<void()> room_;
};

}  // namespace magimu::apps
