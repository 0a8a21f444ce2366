// Drives the Verilated planner. Orders come on standard input, answers go to standard output; wide
// payloads are 32-bit words, one in each number:
//
//   1 n word*n        writes n corners, one payload of `cells` each
//   2 word*           a problem
//   3 word*           draws a shape; answers: cycles from its offer to its end
//   4 gap stop word*  starts a run `gap` cycles later, and stops it in that cycle (0: never)
//       answers: cycles of the run, generations that were told
//   5                 answers: has_problem, has_population, has_best, then the words of `status`
//   6 stall           reads the best paths; with a stall s above 0, records move only in about one
//                     cycle of s; answers: number of bytes, and the bytes
//   7 cycles word*    starts a run, and resets the chip after `cycles` cycles
//   8                 stops, while no run is in progress
//   9 low high        writes a waypoint of the guide

#include "../../sim/harness/harness.hpp"

namespace {

using namespace harness;

class Planner : Design {
public:
    void stop() {
        top_.stop = 1;
        clock();
        top_.stop = 0;
    }

    void reset_in_run(Number cycles) {
        offer(top_.runs___05Fpayload, top_.runs___05Fvalid, top_.runs___05Fready);
        for (Number i = 0; i < cycles; ++i) clock();
        reset();
    }

    void write(const Numbers& corners) {
        top_.cells___05Fvalid = 1;
        for (const auto corner : corners) {
            top_.cells___05Fpayload = corner;
            take(top_.cells___05Fready);
        }
        top_.cells___05Fvalid = 0;
    }

    void pose() { offer(top_.problems___05Fpayload, top_.problems___05Fvalid, top_.problems___05Fready); }

    void lead() {
        const Numbers halves = read_numbers(2);
        top_.guides___05Fpayload = halves[0] | static_cast<std::uint64_t>(halves[1]) << 32;
        top_.guides___05Fvalid = 1;
        take(top_.guides___05Fready);
        top_.guides___05Fvalid = 0;
    }

    void draw() {
        write_numbers({offer(top_.shapes___05Fpayload, top_.shapes___05Fvalid, top_.shapes___05Fready)});
    }

    void run(Number gap, Number stop) {
        for (Number i = 0; i < gap; ++i) clock();
        offer(top_.runs___05Fpayload, top_.runs___05Fvalid, top_.runs___05Fready);
        // Offers in reset must not be taken.
        top_.cells___05Fvalid = top_.problems___05Fvalid = 1;
        top_.shapes___05Fvalid = top_.runs___05Fvalid = top_.guides___05Fvalid = 1;
        Number cycle = 0, bred = 0;
        for (top_.eval(); top_.running; ++cycle, clock(), top_.eval()) {
            if (cycle > limit_) give_up();
            top_.stop = stop != 0 && cycle == stop;
            top_.eval();
            bred += top_.bred;
            if (top_.cells___05Fready || top_.problems___05Fready || top_.shapes___05Fready ||
                top_.runs___05Fready || top_.guides___05Fready) {
                std::exit(5);
            }
        }
        top_.cells___05Fvalid = top_.problems___05Fvalid = 0;
        top_.shapes___05Fvalid = top_.runs___05Fvalid = top_.guides___05Fvalid = top_.stop = 0;
        write_numbers({cycle, bred});
    }

    void tell() {
        for (int i = 0; i < 4; ++i) clock();
        top_.eval();
        Numbers answer{top_.has_problem, top_.has_population, top_.has_best};
        for (std::size_t i = 0; i < sizeof top_.status / 4; ++i) answer.push_back(top_.status[i]);
        write_numbers(answer);
    }

    void read_best(Number stall) {
        top_.best = 1;
        clock();
        top_.best = 0;
        Numbers bytes{0};
        Pauses pauses{stall};
        for (Number i = 0; true; ++i) {
            if (i > limit_) give_up();
            pauses.draw();
            top_.records___05Fready = pauses.moves();
            top_.eval();
            const bool moves = top_.records___05Fvalid && top_.records___05Fready;
            const Number record = top_.records___05Fpayload;
            clock();
            if (moves) bytes.push_back(record & 0xFF);
            if (moves && record >> 8) break;
        }
        top_.records___05Fready = 0;
        bytes[0] = bytes.size() - 1;
        write_numbers(bytes);
    }

private:
    Number take(const CData& ready) {
        const Number cycles = clock_while([&] { return !ready; });
        clock();
        return cycles;
    }

    template <typename Payload>
    Number offer(Payload& payload, CData& valid, const CData& ready) {
        for (std::size_t i = 0; i < sizeof payload / 4; ++i) payload[i] = read_number();
        valid = 1;
        const Number cycles = take(ready);
        valid = 0;
        return cycles;
    }
};

}  // namespace

int main() {
    Planner planner;
    for (Number order; next_order(order);) {
        switch (order) {
            case 1: planner.write(read_numbers(read_number())); break;
            case 2: planner.pose(); break;
            case 3: planner.draw(); break;
            case 4: {
                const Numbers head = read_numbers(2);
                planner.run(head[0], head[1]);
                break;
            }
            case 5: planner.tell(); break;
            case 6: planner.read_best(read_number()); break;
            case 7: planner.reset_in_run(read_number()); break;
            case 8: planner.stop(); break;
            case 9: planner.lead(); break;
            default: return 3;
        }
    }
    return 0;
}
