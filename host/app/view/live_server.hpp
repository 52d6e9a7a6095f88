#pragma once

#include <memory>
#include <string>

#include "host/app/run/step_log.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// Shows a run while it goes on, to a browser of this machine. Listens on 127.0.0.1 alone; all
/// addresses begin with a random word that only the address which is printed tells. Serves no
/// files. Whoever has the address may pause and stop the run.
class LiveServer {
 public:
  /// Starts to listen.
  /// @param port   0: any free one
  /// @param scene  of the run
  /// @param device of the run
  /// @throws SceneError if the port cannot be had, or this build lacks what the page needs
  LiveServer(int port, const Scene& scene, const std::string& device);
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// "http://127.0.0.1:PORT/WORD/"
  std::string address() const;

  /// @param time [s]
  void add_frame(int number, double time, const io::FrameMeshes& meshes);
  void add_step(const StepLine& line);

  /// Returns at once unless the page has paused the run; then when it goes on or is to stop.
  /// @return whether it has waited
  bool wait_while_paused();

  /// Says how the run ended, and gives a page that is open a moment to hear it.
  void end(const std::string& how);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace weft::app
