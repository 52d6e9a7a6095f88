#include "host/app/view/live_server.hpp"

#include <fmt/format.h>

#include "weft/error.hpp"

#ifdef WEFT_HTTPLIB

#include <httplib.h>
#include <signal.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <utility>

#include "host/app/process/stop_signal.hpp"
#include "host/app/view/player_page.hpp"
#include "host/app/view/player_run.hpp"
#include "host/app/view/run_facts.hpp"
#include "host/input/safe_text.hpp"
#include "host/render/picture_values.hpp"

namespace weft::app {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

/// End of the scale of strains: the largest of the run is yet to come.
constexpr double strain_high = 0.1;

/// Base64 that is kept for pages; later frames are not shown.
constexpr std::size_t most_kept = 400'000'000;

/// 128 bits from the system.
std::string random_word() {
  std::random_device source;
  std::string word;
  for (int k = 0; k < 4; ++k) word += fmt::format("{:08x}", static_cast<std::uint32_t>(source()));
  return word;
}

Json facts_of(const Scene& scene, const std::string& device) {
  return {{"scene", one_line(scene.name)},
          {"method", scene.method},
          {"device", device},
          {"step_fields", step_fields()},
          {"steps", Json::array()}};
}

/// A number of a query; 0 if it is none.
std::size_t number_in(const httplib::Request& request, const char* name) {
  const std::string text = request.get_param_value(name);
  std::size_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Sends a text as it is: httplib would compress one that it holds itself, at a cost that the run
/// would feel.
void send(httplib::Response& response, std::string text, const char* type) {
  const auto held = std::make_shared<std::string>(std::move(text));
  response.set_content_provider(
      held->size(), type, [held](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        sink.write(held->data() + offset, length);
        return true;
      });
}

}  // namespace

struct LiveServer::Parts {
  explicit Parts(Json facts) : run(std::move(facts), ranges()) {}

  static PlayerRanges ranges() {
    PlayerRanges r;
    r.strain = strain_high;
    return r;
  }

  void listen(int wanted);
  bool is_for_us(const httplib::Request& request) const;
  std::string news(const httplib::Request& request);

  const std::string word = random_word();
  int port = 0;
  httplib::Server server;
  std::thread thread;
  std::atomic<bool> left{false};  ///< by the thread
  std::mutex mutex;               ///< of all below
  std::condition_variable changed;
  PlayerRun run;
  bool full = false;
  bool paused = false;
  std::string ended;  ///< how; empty: it goes on
  bool end_heard = false;
  Clock::time_point asked{};  ///< when a page has last asked for news
};

/// A page of another origin, whose name leads here, must not get through even with the word.
bool LiveServer::Parts::is_for_us(const httplib::Request& request) const {
  const std::string host = request.get_header_value("Host");
  const std::string here = fmt::format("127.0.0.1:{}", port);
  const std::string origin = request.get_header_value("Origin");
  return host == here && (origin.empty() || origin == "http://" + here);
}

std::string LiveServer::Parts::news(const httplib::Request& request) {
  const std::lock_guard lock(mutex);
  asked = Clock::now();
  Json json = run.news(number_in(request, "frames"), number_in(request, "topologies"),
                       number_in(request, "blobs"), number_in(request, "steps"));
  json["paused"] = paused;
  json["full"] = full;
  json["ended"] = ended.empty() ? Json(nullptr) : Json(one_line(ended));
  if (!ended.empty()) {
    end_heard = true;
    changed.notify_all();
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void LiveServer::Parts::listen(int wanted) {
  using httplib::Request, httplib::Response;
  // A page that is closed while it loads breaks a pipe; that must not stop the run. Whoever writes
  // to standard output sees the error itself.
  ::signal(SIGPIPE, SIG_IGN);
  server.new_task_queue = [] { return new httplib::ThreadPool(4); };
  server.set_payload_max_length(1024);
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"Referrer-Policy", "no-referrer"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"X-Frame-Options", "DENY"}});
  server.set_pre_routing_handler([this](const Request& request, Response& response) {
    if (is_for_us(request)) return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    return httplib::Server::HandlerResponse::Handled;
  });
  const std::string start = "/" + word + "/";
  server.Get(start, [this](const Request&, Response& response) {
    const std::lock_guard lock(mutex);
    if (run.empty()) {
      response.set_header("Refresh", "1");
      return send(response, "There is no frame yet.", "text/plain");
    }
    send(response, live_page(built_shell(), run), "text/html; charset=utf-8");
  });
  server.Get(start + "news", [this](const Request& request, Response& response) {
    send(response, news(request), "application/json");
  });
  for (const bool pause : {true, false})
    server.Post(start + (pause ? "pause" : "continue"), [this, pause](const Request&, Response&) {
      const std::lock_guard lock(mutex);
      paused = pause;
      changed.notify_all();
    });
  server.Post(start + "stop", [this](const Request&, Response&) {
    request_stop();
    const std::lock_guard lock(mutex);
    changed.notify_all();
  });
  if (wanted == 0)
    port = server.bind_to_any_port("127.0.0.1");
  else if (server.bind_to_port("127.0.0.1", wanted))
    port = wanted;
  if (port <= 0)
    throw SceneError("", "--live", std::to_string(wanted),
                     "a port of 127.0.0.1 that is free; none takes any");
  thread = std::thread([this] {
    server.listen_after_bind();
    left = true;
  });
}

LiveServer::LiveServer(int port, const Scene& scene, const std::string& device) {
  if (built_shell().head.empty())
    throw SceneError(
        "--live: this build lacks three.js; install libjs-three and build the program again");
  parts_ = std::make_unique<Parts>(facts_of(scene, device));
  parts_->listen(port);
}

LiveServer::~LiveServer() {
  if (!parts_) return;
  // Before it runs, stop() would do nothing.
  while (!parts_->server.is_running() && !parts_->left) std::this_thread::yield();
  parts_->server.stop();
  parts_->thread.join();
}

std::string LiveServer::address() const {
  return fmt::format("http://127.0.0.1:{}/{}/", parts_->port, parts_->word);
}

void LiveServer::add_frame(int number, double time, const io::FrameMeshes& meshes) {
  PlayerFrame frame;
  frame.number = number;
  frame.time = time;
  frame.meshes = io::in_world(meshes);
  frame.strain = io::strain_values(frame.meshes.cloths);
  const std::lock_guard lock(parts_->mutex);
  parts_->full = parts_->run.size() > most_kept;
  if (!parts_->full) parts_->run.add(frame);
}

void LiveServer::add_step(const StepLine& line) {
  const std::lock_guard lock(parts_->mutex);
  parts_->run.add_step(step_facts(line));
}

bool LiveServer::wait_while_paused() {
  std::unique_lock lock(parts_->mutex);
  if (!parts_->paused) return false;
  // A signal wakes nobody.
  while (parts_->paused && !stop_requested())
    parts_->changed.wait_for(lock, std::chrono::milliseconds(100));
  return true;
}

void LiveServer::end(const std::string& how) {
  std::unique_lock lock(parts_->mutex);
  parts_->ended = how;
  if (Clock::now() - parts_->asked > std::chrono::seconds(3)) return;
  parts_->changed.wait_for(lock, std::chrono::seconds(2), [this] { return parts_->end_heard; });
}

}  // namespace weft::app

#else

namespace weft::app {

struct LiveServer::Parts {};

LiveServer::LiveServer(int, const Scene&, const std::string&) {
  throw SceneError(
      "--live: this build lacks cpp-httplib; install libcpp-httplib-dev and build the program "
      "again");
}
LiveServer::~LiveServer() = default;
std::string LiveServer::address() const {
  return {};
}
void LiveServer::add_frame(int, double, const io::FrameMeshes&) {}
void LiveServer::add_step(const StepLine&) {}
bool LiveServer::wait_while_paused() {
  return false;
}
void LiveServer::end(const std::string&) {}

}  // namespace weft::app

#endif
