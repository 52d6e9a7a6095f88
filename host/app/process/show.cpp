#include "host/app/process/show.hpp"

#include <cerrno>

#include "host/app/process/stop_signal.hpp"

namespace weft::app {

void show_text(std::FILE* out, const std::string& text) {
  errno = 0;
  if (std::fputs(text.c_str(), out) >= 0 && std::fflush(out) == 0) return;
  if (errno == EPIPE) request_stop();
}

}  // namespace weft::app
