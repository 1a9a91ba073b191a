// SPDX-License-Identifier: BSD-3-Clause
#include "apps/live/page_view.h"

#include <cmath>

#include "apps/stream/stream_json.h"
#include "calibration/result/calibration_json.h"

namespace magimu::apps {
namespace {

using Json = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr std::size_t kEventsShown = 12;
constexpr auto kLastWords = 2s;  // for browsers to take the verdict

// Names of files need not be UTF-8.
std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Json rounded(const Vector3& v) {
  Json out = Json::array();
  for (int i = 0; i < 3; ++i) out.push_back(std::round(100.0 * v[i]) / 100.0);
  return out;
}

Json axis_json(int axis) { return axis < 0 ? Json(nullptr) : Json(axis_name(axis)); }

}  // namespace

PageView::PageView(const PageAddress& address) : server_(address, kLivePage) { publish_state(); }

void PageView::sample(const StreamSample& sample) {
  if (sample.mag.empty() || !sample.mag.front()) return;
  points_.add(*sample.mag.front());
  has_points_ = true;
}

void PageView::window(const StreamStatus& status, const std::vector<std::string>&) {
  status_ = status;
  changed_ = true;
}

void PageView::event(const std::string& sentence) {
  events_.push_back(sentence);
  if (events_.size() > kEventsShown) events_.pop_front();
  changed_ = true;
}

void PageView::tick(const StreamStatus& status) {
  if (changed_) publish_state();
  if (server_.browsers() == 0) return;
  Json tick;
  tick["kind"] = "tick";
  tick["mag"] = has_points_ ? rounded(points_.latest()) : Json(nullptr);
  tick["turning"] = axis_json(status.turning);
  tick["silent_s"] = status.silent ? Json(status.silent_s) : Json(nullptr);
  tick["elapsed_s"] = status.elapsed_s;
  // Faults are known before the first window is.
  tick["headline"] = status.headline();
  tick["guidance"] = status.guidance();
  tick["fatal"] = status.fatal() != nullptr;
  server_.publish(PageServer::kTick, dump(tick));
}

std::string PageView::state() const {
  Json out;
  out["kind"] = "state";
  const StreamStatus none;
  const StreamStatus& s = status_ ? *status_ : none;
  out["source"] = s.source;
  out["rate_hz"] = s.rate_hz;
  out["axis"] = axis_json(s.update ? s.update->axis : -1);
  Json points = Json::array();
  for (const Vector3& p : points_.points()) points.push_back(rounded(p));
  out["points"] = std::move(points);
  out["recent"] = events_;
  std::string text = dump(out);
  text.back() = ',';
  text += "\"line\":" + (status_ ? stream_line(s, {}) : std::string("null"));
  if (!end_.empty()) text += ",\"end\":" + end_;
  return text + "}";
}

void PageView::publish_state() {
  changed_ = false;
  server_.publish(PageServer::kState, state());
}

void PageView::finish(const Calibration& c, const std::string& file) {
  Json end = parameters_json(c);
  end["verdict"] = to_string(c.trust.verdict);
  end["reasons"] = c.trust.reasons;
  end["file"] = file;
  end_ = dump(end);
  publish_state();
  server_.finish(kLastWords);
}

void PageView::finish(const std::string& why) {
  end_ = dump({{"verdict", "no"}, {"reasons", {why}}, {"file", ""}});
  publish_state();
  server_.finish(kLastWords);
}

}  // namespace magimu::apps
