// Connects the line of a simulated chip to one TCP client or to a pseudo terminal.
//
// One client at a time has the board. With --keep, further clients may wait for it. As soon as the
// chip answers its client, waiting clients read `kBusy` and are disconnected. If a waiting client
// has sent something, the board is taken from its client once the line has been silent for a second
// in all since the chip's last answer to it, or the chip has not answered `kUnanswered` bytes. So a
// client that is silent, or now and then sends bytes that the chip does not understand, blocks
// another client for a second at most. Bytes that a client sent before it left are discarded, and
// so are the chip's answers to it. A client that is `kFlood` bytes ahead of the chip is
// disconnected: the chip might need minutes to take these bytes before it sees the client leave.
// Bytes that a terminal does not take for a second are lost, as on a real line.
//
// Usage of a simulator with this bridge: PROGRAM --clocks-per-bit N [options]
//   --clocks-per-bit N   divisor of the chip's UART; 0: the chip has a byte-wide port
//   --listen HOST:PORT   address of the server (default 127.0.0.1:0; port 0: any free port)
//   --pty                serve a pseudo terminal instead
//   --keep               wait for another client when one leaves; the chip keeps its state
//   --idle-clocks N      cycles simulated at full speed after the last activity on either line
//   --trace FILE         waveform, if the simulator was built for one
//
// Standard output: `port N` or `pty PATH` when the client can connect, and an answer to each line
// on standard input:
//   (empty)              `cycles N`: cycles simulated until now
//   reset BYTES CYCLES   `armed`: resets the chip for one cycle, CYCLES cycles after it has begun
//                        to receive BYTES more bytes; with 0 bytes the reset is cancelled
// Standard error: errors on the chip's line, and a summary at the end. The program ends with
// status 0 when the client leaves (without --keep), on SIGTERM or SIGINT, at the end of standard
// input, and at the end of its parent process.
//
// Simulated time is independent of real time: a busy chip runs as fast as possible. Only a byte can
// wake an idle chip. Therefore the simulation slows down `--idle-clocks` cycles after the last
// activity, to one service interval per idle sleep, and then needs almost no processor time.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <sys/types.h>

#include "port.hpp"

namespace board {

// Sent to a client when another one has the board; host/device/socket_port.py knows it, too.
constexpr char kBusy[] = "busy: another client uses this board\n";

struct Options {
    unsigned clocks_per_bit = 0;
    std::uint64_t idle_clocks = 1u << 20;
    std::string listen = "127.0.0.1:0";
    std::string trace;
    bool pty = false;
    bool keep = false;

    // Ends the process with status 2 and one sentence on a wrong argument.
    static Options parse(int argc, const char* const* argv);
};

// Intervals at which a simulator serves its client; they depend on the simulator's speed.
struct Pace {
    unsigned service_cycles;  // Cycles between two services of the client; a power of two.
    int idle_sleep_ms;        // Longest sleep of an idle simulation.
};

class Bridge {
public:
    Bridge(const Options& options, const Pace& pace);
    ~Bridge();
    Bridge(const Bridge&) = delete;
    Bridge& operator=(const Bridge&) = delete;

    bool running() const { return running_; }

    // Takes the outputs after a cycle and returns the inputs of the next cycle.
    ToChip clock(const FromChip& pins) {
        if (const auto event = port_.sample(pins); event != UartSampler::Event::kNothing) {
            handle(event);
        }
        ++cycles_;
        if ((cycles_ & (pace_.service_cycles - 1)) == 0) service();
        ToChip inputs = port_.drive(pins);
        if (port_.begun() == reset_byte_) {
            reset_cycle_ = cycles_ + reset_delay_;
            reset_byte_ = kNever;
        }
        inputs.rst = cycles_ < kResetCycles || cycles_ == reset_cycle_;
        return inputs;
    }

private:
    using Clock = std::chrono::steady_clock;

    static constexpr unsigned kResetCycles = 8;
    static constexpr std::size_t kReadAhead = 4096;        // Bytes read ahead of the line.
    static constexpr std::size_t kFlood = 1u << 20;        // The same with --keep and --listen.
    static constexpr std::size_t kUnsentLimit = 1u << 16;  // Maximum of unread bytes.
    static constexpr std::size_t kWaiting = 8;             // Clients that wait for the board.
    // Bytes that a chip with the largest receive buffer takes before it answers.
    static constexpr std::uint64_t kUnanswered = 1u << 15;
    static constexpr unsigned kReportedErrors = 10;
    static constexpr std::uint64_t kNever = ~std::uint64_t{0};

    // A client that waits for the board.
    struct Waiting {
        int fd;
        Clock::time_point since;
    };

    void handle(UartSampler::Event event);
    void service();
    void count_silence();
    void settle();
    void serve_client();
    void send_to_client();
    void meet_clients();
    void refuse_some();
    std::vector<Waiting>::iterator first_waiting(bool spoken);
    void seat(int client);
    void lose_client();
    void check_control();
    void obey(const std::string& line);
    void sleep(short client_events);
    void open_listener();
    void open_terminal();

    const Options options_;
    const Pace pace_;
    const pid_t parent_;
    Port port_;
    std::vector<std::uint8_t> unsent_;
    int listener_ = -1;
    int client_ = -1;
    std::vector<Waiting> waiting_;  // The longest first.
    int terminal_ = -1;  // Own handle of the terminal's far end, which stays open between users.
    bool running_ = true;
    bool settling_ = false;  // The chip still answers a client that has left.
    bool moved_ = false;     // A byte has passed since the latest service.
    std::string orders_;     // Begun line of standard input.
    std::uint64_t cycles_ = 0;
    std::uint64_t reset_byte_ = kNever;
    std::uint64_t reset_delay_ = 0;
    std::uint64_t reset_cycle_ = kNever;
    std::uint64_t quiet_from_ = 0;
    std::uint64_t full_speed_until_ = 0;
    std::uint64_t bytes_out_ = 0;
    std::uint64_t line_errors_ = 0;
    Clock::time_point started_;
    Clock::time_point control_due_;
    Clock::time_point moved_at_;  // When a byte passed, or the client got the board.
    Clock::time_point counted_at_;
    Clock::duration silence_{0};  // Silence of the line since an answer to the client.
    Clock::time_point answered_at_;  // When a byte of the chip was sent to the client.
    std::uint64_t answered_begun_ = 0;  // Bytes that had begun on the line to the chip then.
    Clock::time_point settled_at_;  // When the chip's last answers are no longer waited for.
    Clock::duration slept_{0};
};

}  // namespace board
