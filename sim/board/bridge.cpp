#include "bridge.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

namespace board {
namespace {

constexpr auto kControlPeriod = std::chrono::milliseconds{50};
constexpr auto kIdleLimit = std::chrono::seconds{1};            // See bridge.hpp.
constexpr auto kSettleLimit = std::chrono::milliseconds{500};  // Wait for the chip's last answers.
constexpr int kBacklog = 64;
constexpr int kSocketBytes = 1 << 16;  // Size of the kernel's buffers, in each direction.

volatile std::sig_atomic_t stop_requested = 0;

[[noreturn]] void fail(int status, const std::string& sentence) {
    std::fprintf(stderr, "simulator: %s\n", sentence.c_str());
    std::exit(status);
}

std::uint64_t parse_number(const std::string& name, const char* text, std::uint64_t minimum) {
    char* end = nullptr;
    errno = 0;
    const auto value = std::strtoull(text, &end, 10);
    if (errno != 0 || *text < '0' || *text > '9' || *end != '\0' || value < minimum) {
        fail(2, name + " must be an integer from " + std::to_string(minimum) + ", not " + text);
    }
    return value;
}

void set_nonblocking(int fd) { fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK); }

// Tells whether the far end of a connection sends no more, though bytes may wait to be read.
bool has_left(int fd) {
    pollfd state{fd, POLLRDHUP, 0};
    return poll(&state, 1, 0) > 0;
}

// Tells whether a client that has not left has sent bytes that are still unread.
bool has_spoken(int fd) {
    pollfd state{fd, POLLIN, 0};
    return !has_left(fd) && poll(&state, 1, 0) > 0;
}

void refuse(int fd) {
    // To close with unread bytes would reset the connection, and the client might lose the text.
    std::uint8_t unread[4096];
    for (int i = 0; i < kSocketBytes / 4096 && read(fd, unread, sizeof unread) > 0; ++i) {
    }
    if (write(fd, kBusy, sizeof kBusy - 1) < 0) errno = 0;  // It has left.
    close(fd);
}

}  // namespace

Options Options::parse(int argc, const char* const* argv) {
    Options options;
    bool has_divisor = false;
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i];
        const auto value = [&] {
            if (i + 1 >= argc) fail(2, name + " needs a value");
            return argv[++i];
        };
        if (name == "--clocks-per-bit") {
            options.clocks_per_bit = static_cast<unsigned>(parse_number(name, value(), 0));
            has_divisor = true;
        } else if (name == "--idle-clocks") {
            options.idle_clocks = parse_number(name, value(), 0);
        } else if (name == "--listen") {
            options.listen = value();
        } else if (name == "--trace") {
            options.trace = value();
        } else if (name == "--pty") {
            options.pty = true;
        } else if (name == "--keep") {
            options.keep = true;
        } else {
            fail(2, "unknown argument " + name);
        }
    }
    if (!has_divisor) fail(2, "--clocks-per-bit is required");
    if (options.clocks_per_bit == 1) fail(2, "--clocks-per-bit must be 0, or 2 or more, not 1");
    return options;
}

Bridge::Bridge(const Options& options, const Pace& pace)
    : options_{options},
      pace_{pace},
      parent_{getppid()},
      port_{options.clocks_per_bit},
      started_{Clock::now()},
      counted_at_{started_} {
    struct sigaction action {};
    action.sa_handler = [](int) { stop_requested = 1; };
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGINT, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    if (options_.pty) {
        open_terminal();
    } else {
        open_listener();
    }
    std::fflush(stdout);
}

Bridge::~Bridge() {
    const std::chrono::duration<double> elapsed = Clock::now() - started_ - slept_;
    std::fprintf(stderr,
                 "simulator: %llu cycles in %.3f s (%.0f cycles/s), %llu bytes to the chip, "
                 "%llu bytes from it, %llu line errors\n",
                 static_cast<unsigned long long>(cycles_), elapsed.count(),
                 static_cast<double>(cycles_) / elapsed.count(),
                 static_cast<unsigned long long>(port_.begun()),
                 static_cast<unsigned long long>(bytes_out_),
                 static_cast<unsigned long long>(line_errors_));
    for (const int fd : {listener_, client_, terminal_}) {
        if (fd >= 0) close(fd);
    }
    for (const auto& client : waiting_) close(client.fd);
}

void Bridge::open_listener() {
    const auto colon = options_.listen.rfind(':');
    if (colon == std::string::npos) {
        fail(2, "--listen must be HOST:PORT, not " + options_.listen);
    }
    const std::string host = options_.listen.substr(0, colon);
    const std::string port = options_.listen.substr(colon + 1);
    addrinfo hints{};
    hints.ai_family = AF_INET;
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    addrinfo* found = nullptr;
    if (const int error = getaddrinfo(host.empty() ? nullptr : host.c_str(), port.c_str(), &hints,
                                      &found)) {
        fail(2, "cannot listen on " + options_.listen + ": " + gai_strerror(error));
    }
    const int on = 1;
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &kSocketBytes, sizeof kSocketBytes);
    setsockopt(listener_, SOL_SOCKET, SO_SNDBUF, &kSocketBytes, sizeof kSocketBytes);
    sockaddr_in address{};
    socklen_t length = sizeof address;
    if (listener_ < 0 || bind(listener_, found->ai_addr, found->ai_addrlen) != 0 ||
        listen(listener_, kBacklog) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
        fail(2, "cannot listen on " + options_.listen + ": " + std::strerror(errno));
    }
    freeaddrinfo(found);
    std::printf("port %u\n", unsigned{ntohs(address.sin_port)});
}

void Bridge::open_terminal() {
    char path[64];
    termios raw{};
    if (openpty(&client_, &terminal_, path, nullptr, nullptr) != 0 ||
        tcgetattr(terminal_, &raw) != 0) {
        fail(1, std::string{"cannot open a pseudo terminal: "} + std::strerror(errno));
    }
    cfmakeraw(&raw);
    tcsetattr(terminal_, TCSANOW, &raw);
    set_nonblocking(client_);
    std::printf("pty %s\n", path);
}

void Bridge::handle(UartSampler::Event event) {
    full_speed_until_ = cycles_ + options_.idle_clocks;
    if (event == UartSampler::Event::kByte) {
        ++bytes_out_;
        moved_ = true;
        quiet_from_ = cycles_;
        if (client_ >= 0 && !settling_) unsent_.push_back(port_.byte());
        return;
    }
    if (++line_errors_ <= kReportedErrors) {
        std::fprintf(stderr, "simulator: %s on the chip's tx at cycle %llu\n",
                     event == UartSampler::Event::kGlitch ? "a glitch" : "a framing error",
                     static_cast<unsigned long long>(cycles_));
    }
}

// Serves everything outside the chip; sleeps while both sides are idle.
void Bridge::service() {
    serve_client();
    count_silence();
    if (Clock::now() >= control_due_) check_control();
    if (settling_) settle();
    if (!port_.idle()) {
        moved_ = true;
        full_speed_until_ = cycles_ + options_.idle_clocks;
    } else if (running_ && !settling_ && cycles_ >= full_speed_until_) {
        sleep(POLLIN);
        count_silence();
        serve_client();
    }
}

// Adds the time since the last count to the silence, unless a byte has passed.
void Bridge::count_silence() {
    const auto now = Clock::now();
    if (moved_) {
        moved_at_ = now;
    } else {
        silence_ += now - counted_at_;
    }
    moved_ = false;
    counted_at_ = now;
}

// Ends the time in which the chip's answers are dropped: with silence, or at the limit.
void Bridge::settle() {
    if (!port_.idle()) quiet_from_ = cycles_;
    settling_ = cycles_ - quiet_from_ < port_.quiet_cycles() &&
                Clock::now() < settled_at_;
}

void Bridge::serve_client() {
    if (client_ < 0) meet_clients();
    const bool many_clients = options_.keep && !options_.pty;
    if (many_clients && port_.waiting() >= kFlood) lose_client();
    if (client_ >= 0 && !settling_ && (many_clients || port_.waiting() < kReadAhead)) {
        std::uint8_t bytes[kReadAhead];
        const auto count = read(client_, bytes, sizeof bytes);
        if (count > 0) {
            port_.push(bytes, static_cast<std::size_t>(count));
            moved_ = true;
            full_speed_until_ = cycles_ + options_.idle_clocks;
        } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
            lose_client();
        }
    }
    send_to_client();
    // A UART cannot wait, but simulated time can: the clock stops until the client reads.
    while (running_ && unsent_.size() > kUnsentLimit) {
        sleep(POLLOUT);
        count_silence();
        check_control();
        send_to_client();
    }
}

void Bridge::send_to_client() {
    if (client_ < 0 || unsent_.empty()) return;
    const auto count = write(client_, unsent_.data(), unsent_.size());
    if (count > 0) {
        unsent_.erase(unsent_.begin(), unsent_.begin() + count);
        moved_at_ = answered_at_ = Clock::now();
        answered_begun_ = port_.begun();
        silence_ = Clock::duration::zero();
    } else if (count < 0 && errno != EAGAIN && errno != EINTR) {
        lose_client();
    } else if (options_.pty && Clock::now() - moved_at_ > kIdleLimit) {
        unsent_.clear();
    }
}

// Accepts and refuses clients, and gives the board to the one that waits.
void Bridge::meet_clients() {
    if (options_.pty) return;
    std::erase_if(waiting_, [](const auto& other) {
        return has_left(other.fd) && close(other.fd) == 0;
    });
    if (client_ >= 0 && has_left(client_)) lose_client();
    for (int i = 0; i < kBacklog; ++i) {
        const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (client < 0) break;
        if (client_ < 0) {
            seat(client);
        } else if (options_.keep) {
            waiting_.push_back({client, Clock::now()});
        } else {
            refuse(client);
        }
    }
    refuse_some();
    const auto limit = Clock::now() - kIdleLimit;
    const bool is_used =
        silence_ < kIdleLimit && port_.begun() - answered_begun_ <= kUnanswered;
    const bool is_wanted = std::any_of(waiting_.begin(), waiting_.end(), [&](const auto& other) {
        return other.since < limit && has_spoken(other.fd);
    });
    if (is_wanted && !is_used) lose_client();
}

// Tells clients that the board is busy: once it is, or if too many wait, silent ones first.
void Bridge::refuse_some() {
    std::erase_if(waiting_, [this](const auto& other) {
        if (other.since > answered_at_) return false;
        refuse(other.fd);
        return true;
    });
    while (waiting_.size() > kWaiting) {
        auto other = first_waiting(false);
        if (other == waiting_.end()) --other;
        refuse(other->fd);
        waiting_.erase(other);
    }
}

// Returns the client that has waited longest among clients that have sent bytes, or have not.
std::vector<Bridge::Waiting>::iterator Bridge::first_waiting(bool spoken) {
    return std::find_if(waiting_.begin(), waiting_.end(),
                        [=](const auto& other) { return has_spoken(other.fd) == spoken; });
}

void Bridge::seat(int client) {
    const int on = 1;
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    client_ = client;
    moved_at_ = Clock::now();
    answered_begun_ = port_.begun();
    silence_ = Clock::duration::zero();
}

void Bridge::lose_client() {
    if (options_.pty) return;  // The far end is open, so the error is temporary.
    close(client_);
    client_ = -1;
    if (!options_.keep) running_ = false;
    unsent_.clear();
    port_.drop();
    settling_ = true;
    quiet_from_ = cycles_;
    settled_at_ = Clock::now() + kSettleLimit;
    if (waiting_.empty()) return;
    auto next = first_waiting(true);
    if (next == waiting_.end()) next = waiting_.begin();
    seat(next->fd);
    waiting_.erase(next);
}

// Handles signals and clients, answers standard input, and ends when the parent does.
void Bridge::check_control() {
    control_due_ = Clock::now() + kControlPeriod;
    if (stop_requested || getppid() != parent_) running_ = false;
    meet_clients();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 0) <= 0) return;
    char text[256];
    const auto count = read(STDIN_FILENO, text, sizeof text);
    if (count <= 0) running_ = false;
    for (ssize_t i = 0; i < count; ++i) {
        if (text[i] == '\n') {
            obey(orders_);
            orders_.clear();
        } else if (orders_.size() < sizeof text) {
            orders_ += text[i];
        }
    }
    std::fflush(stdout);
}

void Bridge::obey(const std::string& line) {
    unsigned long long bytes, delay;
    if (line.empty()) {
        std::printf("cycles %llu\n", static_cast<unsigned long long>(cycles_));
    } else if (std::sscanf(line.c_str(), "reset %llu %llu", &bytes, &delay) == 2) {
        reset_byte_ = bytes == 0 ? kNever : port_.begun() + bytes;
        reset_delay_ = delay;
        reset_cycle_ = kNever;
        std::printf("armed\n");
    } else {
        std::printf("unknown %s\n", line.c_str());
    }
}

void Bridge::sleep(short client_events) {
    const auto start = Clock::now();
    pollfd wakers[] = {{STDIN_FILENO, POLLIN, 0},
                       {client_ >= 0 ? client_ : listener_, client_events, 0}};
    poll(wakers, 2, pace_.idle_sleep_ms);
    if (wakers[0].revents != 0) control_due_ = start;
    slept_ += Clock::now() - start;
}

}  // namespace board
