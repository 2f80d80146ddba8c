"""What to do about each reason and remark: one line each, printed beside it wherever it is told.

Causes stand before what follows from them: a spike leaves no fit, and it is the spike that is to be mended
(emg2vsa/extraction/diagnosis.py chooses one for a recording).
docs/how-to/coordinator.md lists them all; a test holds the two together.
"""

from __future__ import annotations

import re
from itertools import combinations
from typing import NamedTuple

from emg2vsa.extraction.reasons import PRESSES_NAMED


class Remedy(NamedTuple):
    """``found``: regular expression of a reason, in full. ``example``: one as it is printed. ``means``, ``do``: words.

    rejects : whether the press, or the recording, is not used for it; None: it depends on how much.
    """

    found: str
    example: str
    means: str
    do: str
    rejects: bool | None


REMEDIES = (
    Remedy(r"force looks like EMG, and .* like force; were the two channels exchanged\?",
           "force looks like EMG, and FDS like force; were the two channels exchanged?",
           "force is as fast as EMG, and a muscle's channel as slow as force",
           "exchange the names of the two channels in the study file, with their units", True),
    Remedy(r"force returns to zero by itself, .*; is it AC-coupled\?",
           "force returns to zero by itself, within 0.53 s (time constant); is it AC-coupled?",
           "after each release force rises again in proportion to what it lacks: it ran through a high-pass filter",
           "set the amplifier of the force transducer to DC coupling; record again", True),
    Remedy(r"force .*is its sign -?1\?", "force rises while EMG is below its rest; is its sign -1?",
           "releases look like presses; every press of the recording is rejected",
           "set sign = -1 (or remove it) at the force channel of the study file", True),
    Remedy(r".* during a press; is its unit .*", "EDC is 35 mV during a press; is its unit mV, or its gain 10^3?",
           "surface EMG of a press is 1 uV to 5 mV",
           "set unit or gain of the channel in the study file to the one that is asked for", True),
    Remedy(r".* are one signal .*; was one channel exported twice\?",
           "EDC and FDS are one signal (r = 1.00); was one channel exported twice?",
           "two channels hold the same samples, or nearly",
           "correct the channel names, or export again; else move the electrodes apart", True),
    Remedy(r".* is never (negative|positive); is it rectified already\?",
           "EDC is never negative; is it rectified already?", "the file holds processed EMG",
           "export the raw EMG", True),
    Remedy(r".* lies below 20 Hz; is it an envelope, .*",
           "98 % of the power of EDC lies below 20 Hz; is it an envelope, or another signal, instead of raw EMG?",
           "the file holds processed EMG, or the channel is force or another sensor",
           "export the raw EMG, or correct the channel name", True),
    Remedy(r".* and does not follow the force; is its electrode on\?",
           "99 % of the power of FDS lies below 20 Hz, and does not follow the force; is its electrode on?",
           "slow wander without EMG", "press the electrode on, check the channel name, then record again", True),
    Remedy(r"force peaks at .* N; is its unit .*", "force peaks at 1.8 N; is its unit lbf (1 lbf = 4.448 N)?",
           "presses miss the window by the ratio of two units",
           "set unit of the force channel in the study file to the one that is asked for", True),
    Remedy(r"(excluded|accepted) by hand: .*", "excluded by hand: sneezed",
           "an entry [[exclude]] or [[accept]] of the study file", "", None),
    Remedy(r"(operator|session): .*", "operator: repeat: too fast",
           "the session put the press aside while the participant was there: it was repeated, or broken off", "", True),
    Remedy(r"\[\[accept\]\] of one press does not overrule a fault of its recording: .*",
           "[[accept]] of one press does not overrule a fault of its recording: the curve is sound",
           "the fault spoils every press, so that one cannot be sound alone",
           "mend the fault; or, where it is none, accept the whole recording: [[accept]] without repetition", True),
    Remedy(r"recording not used: .*", "recording not used: anna_3.csv: expected a recording, but found an empty file.",
           "one of several recordings of a participant on a specimen was left out",
           "export it again, or take it out of the folder", False),
    Remedy(r"\[\[(exclude|accept)\]\] names press .*", "[[exclude]] names press 12, of 10 found",
           "there is no such press", "correct the number in the study file", False),
    Remedy(r"the same recording as .*", "the same recording as P03/S1",
           "one file stands for two, also exported with other digits, cut or shifted: the fluctuations of its presses "
           "are those of the other's; neither is used, for nobody knows whose they are",
           "correct the file name or path of one of the two, or [[accept]] the one that is right and say why", True),
    Remedy(r"its EMG is unlike the other recordings by a factor .*; is its gain right\?.*",
           "its EMG is unlike the other recordings by a factor (EDC 2, FDS 2); is its gain right? (b 2.03 times)",
           "levels jumped against the person's other recordings, or with the noise at rest against other people's",
           "check gain and unit of the channel for this recording; [[accept]] it where they are right", True),
    Remedy(r".*, unlike all others; was (it low-passed or resampled|it high-passed|it filtered or rectified|a notch "
           r"filter run)\?.*",
           "EDC ends at 58 Hz, unlike all others; was it low-passed or resampled? (b -34 %)",
           "the band of the file's EMG is not that of the study's other recordings; told only where b changes by less "
           "than 8 %",
           "export the raw EMG, as for the other recordings", None),
    Remedy(r".* Hz, unlike all others; is it an envelope\?.*",
           "EDC lies below 37 Hz, unlike all others; is it an envelope? (b -79 %)",
           "the file holds processed EMG", "export the raw EMG, as for the other recordings", True),
    Remedy(r"its time runs .* times as long as in the other recordings .*",
           "its time runs 1.1 times as long as in the other recordings (mains at 45.4 Hz); is its rate right?",
           "the mains, or all frequencies and durations, stand elsewhere than in the other recordings",
           "correct the sampling rate of the file or in the study file", True),
    Remedy(r"its presses peak at .* N, unlike all others; is its unit .*",
           "its presses peak at 28.5 N, unlike all others; is its unit ozf?",
           "peak forces are off by the ratio of two units",
           "set unit of the force channel in the study file to the one that is asked for", True),
    Remedy(r"b of .* against all other participants; were .* swapped\?",
           "b of S1 is below that of S5, against all other participants; were S1 and S5 swapped?",
           "the order of the two specimens contradicts everybody else's",
           "look into the protocol; swap the names of the two files if need be", False),
    Remedy(r".* are as loud as each other elsewhere; were they exchanged\?.*",
           "EDC and FDS are as loud as each other elsewhere; were they exchanged? (b +3 %)",
           "the levels of two muscles have changed places; their sum is right", "correct the channel names", False),
    Remedy(r"record begins at .* N", "record begins at 5.84 N",
           "recording started during the press (rejected where more than `max_missed_n` is missing)",
           "start recording, wait 3 s, then press", None),
    Remedy(r"at the edge of the record", "at the edge of the record", "recording stopped during the press",
           "wait 3 s before stopping", None),
    Remedy(r"EMG does not cover the whole loading phase", "EMG does not cover the whole loading phase",
           "EMG began later or ended earlier than the press, filter margins included",
           "start the EMG first, stop it last", True),
    Remedy(r".*: .* segments, with gaps of .*",
           "EMG: 2 segments, with gaps of 0.3 s after 120 s; each segment is a channel of its own.",
           "samples were lost, or the clock was reset; only the segment whose channel is named is analysed",
           "check the link to the recording computer; record again, or name the other segment", False),
    Remedy(r".* Hz stated, .* Hz by its time stamps; the latter counts\.",
           "EMG: 1000 Hz stated, 985 Hz by its time stamps; the latter counts.",
           "samples were lost all along, or the rate was stated wrongly (told from 0.1 %)",
           "check the link and the rate of the device; record again if samples were lost", False),
    Remedy(r".*: its time stamps wander .* ms off an even grid\.",
           "EMG: its time stamps wander 42 ms off an even grid.",
           "samples were lost in small pieces, or the computer was too busy to stamp them in time (told from 10 ms)",
           "close other programs, check the link, then record again", False),
    Remedy(r".* is held, or a straight line, in .* of its samples",
           "EDC is held, or a straight line, in 24 % of its samples",
           "packets were lost, and somebody repeated the last value, wrote zeros or drew a line in their place",
           "shorten the distance to the radio and free its channel; export without filling gaps; record again", True),
    Remedy(r".* misses .* samples", "FDS misses 12 samples",
           "samples are missing during the press: bridged, left out from 10 ms on (rejected above a tenth of it)",
           "check the wireless link; export again if it is rejected", None),
    Remedy(r".* is flat", "FDS is flat", "the channel holds one value: sensor off, cable out, or the wrong channel",
           "check the sensor, then record again", True),
    Remedy(r"transducer overloaded in .* samples", "transducer overloaded in 210 samples",
           "a gauge of the force transducer was at the end of its range during the press: force is wrong",
           "use a larger range, or unload the transducer's mount; record again", True),
    Remedy(r"gauge .*: .* samples at the end of its range .*; force is wrong there",
           "gauge G1: 210 samples at the end of its range (-10 to 10 V); force is wrong there",
           "a gauge of the force transducer was overloaded somewhere in the recording",
           "use a larger range, or unload the transducer's mount; record again", False),
    Remedy(r".* is stored in steps of .*, coarse beside its EMG",
           "EDC is stored in steps of 20 uV, coarse beside its EMG",
           "the converter, or the export, rounds to a fifth of the EMG's level or more",
           "raise the gain or lower the range of the converter; export with all digits", False),
    Remedy(r".* clips in .* of samples", "FDS clips in 16 % of samples",
           "the amplifier was saturated (`clip_share`)", "lower the gain, check the electrode, record again",
           True),
    Remedy(r".* has no sample far above .*; is it saturated\?",
           "EDC has no sample far above 66 uV; is it saturated?",
           "the largest samples crowd together, as at the end of an amplifier's range",
           "lower the gain, then record again", False),
    Remedy(r"force was sampled at about .* Hz.*",
           "force was sampled at about 5 Hz, and held or interpolated to 1000 Hz",
           "force bends on a slow, even grid only; what a press does between is lost, and its lag is that of the grid",
           "record force at 100 Hz or more, and export it at its own rate", False),
    Remedy(r".* holds one value for .* ms", "FDS holds one value for 39 ms",
           "lost samples, left out (told above 10 ms; rejected above a tenth of the press)",
           "check the wireless link; record again if it is rejected", None),
    Remedy(r".* repeats .* of its samples.*", "FDS repeats 50 % of its samples, as if held from about 500 Hz",
           "the channel was sampled more slowly than the file says (above 30 %)", "check the export settings", False),
    Remedy(r".* of its samples twice; did the link send packets again\?",
           "EDC has 9.9 % of its samples twice; did the link send packets again?",
           "a wireless link repeated packets, and as many samples may be lost", "export again; check the link", False),
    Remedy(r"the lag of force drifts by .* ms a second; do the clocks differ\?",
           "the lag of force drifts by 1.0 ms a second; do the clocks differ?",
           "EMG and force were sampled by two clocks of different rates: 1.0 ms a second are 1000 ppm",
           "record both by one device", False),
    Remedy(r"force follows EMG by -?\d{3,} ms, which .*",
           "force follows EMG by 2000 ms, which lowers b by more than 20 %",
           "no muscle is so late: EMG and force were not started together, or a radio lost samples that nobody told",
           "shorten the distance to the radio, free its channel and record again; of clocks that were started apart "
           'align by a trigger, or with align = "lag"', True),
    Remedy(r".* has spikes: .*", "EDC has spikes: 3 samples far from their neighbours",
           "single samples that no muscle makes: a bad contact or a disturbed link; a line bridges them",
           "check plugs and the wireless link; the press is used where its interval allows it", False),
    Remedy(r".* has a burst of .* times its level", "FDS has a burst of 4.2 times its level",
           "a tenth of a second far louder than the other presses, left out: the cable was touched, or the hand moved",
           "tape the cables down; the press is used where its interval allows it", False),
    Remedy(r".* (fades|grows) to .* over the presses", "EDC fades to 33 % over the presses",
           "the muscle's level changes from the first press to the last: a drying or loosening electrode, or fatigue",
           "press the electrode on or renew it; longer rests; record again", False),
    Remedy(r".* shows the heart at rest, .*", "EDC shows the heart at rest, 71 beats a minute",
           "heart beats in the EMG", "move the reference electrode to the same arm, away from the trunk", False),
    Remedy(r"muscles are tense between presses, .*",
           "muscles are tense between presses, up to 3.2 times as much as when they rest most",
           "EMG of lulls differs by more than noise does: told beside a lag that presses do not share, for what the "
           "muscles do between presses spoils its estimate",
           "ask to relax between presses, and wait until EMG is quiet", False),
    Remedy(r".* is as silent as at rest .*", "EDC is as silent as at rest (0.1 dB over it)",
           "the press does not show in this muscle, within 1 dB: the electrode is off, the wrong channel is named, or "
           "this person does not use the antagonist",
           "check electrode and channel name, then record again; where the muscle shows when it is tensed alone, "
           "[[accept]] the recording and say so", True),
    Remedy(r".* does not rise with force .*", "FDS does not rise with force (r = -0.00)",
           "the channel knows nothing of the press: electrode off, or the wrong channel",
           "check electrode and channel name, then record again", False),
    Remedy(r".* (moves|move) for .* s, which .* left out.*",
           "EDC moves for 0.11 s, which is left out, with which b would change by -38 %",
           "the first touch, or a tug, moves electrode or cable: power below EMG, many times the usual",
           "tape the cables down; the press is used where its interval allows it", None),
    Remedy(r"hum changes when the specimen is touched, which lowers b by about .*",
           "hum changes when the specimen is touched, which lowers b by about 4 %",
           "the press holds hum of 50 or 60 Hz that the rests do not, or of another size (told above 1 %)",
           "connect the specimen's metal and the amplifier to one earth; move chargers and cables away", False),
    Remedy(r".* times as loud as .*; are their gains right\?", "EDC is 80 times as loud as FDS; are their gains right?",
           "muscles of one forearm differ by less than 50 times, or 5 where their rests differ as much",
           "check gain and unit of both channels", False),
    Remedy(r".* share about .*: crosstalk", "EDC and FDS share about 32 % of their signal (r = 0.58): crosstalk",
           "both electrodes pick up the same muscle", "move the electrodes apart, or along each muscle", False),
    Remedy(r"reached .* of .* N", "reached 5.61 of 7 N", "the press ended too low",
           "ask for firmer presses; show the target force", True),
    Remedy(r"lasted .*, longer than .*", "lasted 20.1 s, longer than 20 s", "too slow (`max_duration_s`)",
           "ask for a steady press", True),
    Remedy(r"force falls on .* of its path", "force falls on 3.6 % of its path",
           "the finger went back on the way (told above `warn_falling_share`; rejected above `max_falling_share`)",
           "ask for one smooth press", None),
    Remedy(r"lasted .*, shorter than .*", "lasted 0.41 s, shorter than 0.5 s",
           "from the lower to the upper force too fast (`min_duration_s`)", "ask for slower presses", True),
    Remedy(r"force is not tared: the record never rests.*",
           'force is not tared: the record never rests (tare = "none" where it is zeroed)',
           "the zero of the force is unknown",
           'record 3 s without touching, and lift the finger between presses; or set tare = "none"', True),
    Remedy(r"the zero of force moves by .* N around this press",
           "the zero of force moves by 0.27 N around this press",
           "the sensor's zero wandered or jumped, or the finger leant on the specimen (told above 0.1 N; rejected "
           "above `max_gap_force_n`)",
           "lift the finger between presses; let the sensor warm up, check its mount and cable", None),
    Remedy(r"force rests at .* N before contact", "force rests at 0.52 N before contact",
           "the finger leant on the specimen, or the sensor drifted (`max_gap_force_n`)",
           "ask to lift the finger between presses", False),
    Remedy(r"EMG at .* Hz holds only what lies below .*", "EMG at 200 Hz holds only what lies below 100 Hz",
           "a good part of EMG lies above half the sampling rate", "record and export at 1000 Hz or more", False),
    Remedy(r"mains is .* of the power of .*", "mains is 51 % of the power of FDS", "hum of 50 or 60 Hz (above 30 %)",
           "check the reference electrode, cables and chargers", False),
    Remedy(r"noise at rest lowers b by about .*", "noise at rest lowers b by about 7 %",
           "the envelope at rest is part of that of the press, and flattens its curve",
           'keep the default rest_level = "subtract"; check electrodes and cables', False),
    Remedy(r"the rest level that was subtracted raises b by .*", "the rest level that was subtracted raises b by 11 %",
           "b was corrected by so much for noise (told above 5 %, and above 2 % where the rests differ); "
           "muscles tense in every lull are taken for noise",
           "look at the EMG at rest on the participant's page; lower the noise, or ask to relax", False),
    Remedy(r"the baseline of .* wanders by .*; it was removed",
           "the baseline of EDC wanders by 3 mV; it was removed",
           "a slow voltage of electrode or cable, far larger than the EMG; the band-pass takes it out, b is right",
           "nothing now; next time clean the skin, let the electrodes settle, and tape the cables down", False),
    Remedy(r"the lag of force differs by .* ms \(standard deviation\)",
           "the lag of force differs by 100 ms (standard deviation)",
           "presses, or recordings, do not share one lag (told above 30 ms, rejected above 100 ms): b of each is off",
           "shorten the distance to the radio and free its channel; record both by one device", None),
    Remedy(r"force follows EMG by .* ms, which .*", "force follows EMG by 80 ms, which lowers b by about 9 %",
           "the muscle's own delay (30 to 100 ms), a filter in the sensor, or two clocks that differ",
           'set align = "lag", or state delay_s of the sensor', False),
    Remedy(r"lag of force is .* from .*", "lag of force is 80 ms from the 20 ms of the session",
           "EMG and force were not started together as in the other recordings",
           'align the files by a trigger, or set align = "lag"', False),
    Remedy(r"presses: none; .*", "presses: none; tared force goes from -0.02 to 3.1 N, the window is 0.5 to 7 N",
           "force never passed from the lower to the upper force",
           "compare the two ranges: pressed too lightly, or a wrong unit or window", True),
    Remedy(r".* presses found, .* wanted", "4 presses found, 5 wanted", "too few or too many",
           "count with the participant; record the missing ones", False),
    Remedy(r".* is .* dB over rest", "EDC is 3.2 dB over rest",
           "the muscle is hardly louder than at rest (`min_snr_db`)",
           "ask to relax between presses; check the electrode", False),
    Remedy(r"b is expected to be .* % off: lag", "b is expected to be 14 % off: lag",
           "EMG and force seem to be apart, or presses by different times, and too few presses tell by how much",
           "start both by one trigger, or record both by one device; more presses tell the lag better", True),
    Remedy(r"b is expected to be .* % (too low|too high|off): lost samples",
           "b is expected to be 24 % off: lost samples",
           "the samples that were lost may move b by more than the half width of its interval",
           "shorten the distance to the radio and free its channel; record again", True),
    Remedy(r"b is expected to be .* % (too low|too high|off): .*", "b is expected to be 14 % too low: lag",
           "what was found, and could not be corrected, moves b by more than `max_bias`, or than the half width of its "
           "interval; the cause is the largest of the press's budget",
           "look at the budget on the participant's page, mend its cause, or [[accept]] the press and say why", True),
    Remedy(r"ill-conditioned fit: .*", "ill-conditioned fit: force changes by 1e-05 of itself, b keeps 11 digits",
           "the press holds one force only", "ask for presses that rise through the whole window", False),
    Remedy(r"no fit: .*", "no fit: 2 force bins", "too little of the press can be used", "repeat the press", True),
    Remedy(r"its fit explains too little .*", "its fit explains too little (adjusted R2 -0.05)",
           "the press does not follow v = a + b ln F (`min_adj_r2`), and b is uncertain by more than a fifth "
           "of the activity: movement, spikes, or no contraction",
           "look at the press on the participant's page; fix cables and electrodes, then repeat it (or robust = true)",
           True),
    Remedy(r"its slope is .* times less certain than the others of its recording",
           "its slope is 12 times less certain than the others of its recording",
           "too little of the press is left to fit (`max_b_error_ratio`)", "repeat the press", True),
    Remedy(r"its slope is uncertain by .* %", "its slope is uncertain by 450 %",
           "b may be anything, its interval is so wide (`max_b_error`, and a fifth of the activity)",
           "repeat the press, more slowly", True),
)  # fmt: skip
_FOUND = tuple((re.compile(remedy.found), remedy) for remedy in REMEDIES)


def remedy_of(line: str) -> str:
    """What to do about a reason, or several joined by "; ", as ``grouped`` may name presses before; "" if unknown.

    Of several that of the one that stands first in ``REMEDIES``: causes stand before what follows from them.
    """
    words = re.sub(PRESSES_NAMED, "", line).split("; ")
    spans = combinations(range(len(words) + 1), 2)
    reasons = ["; ".join(words[begin:end]) for begin, end in spans]
    found = (remedy.do for pattern, remedy in _FOUND if remedy.do and any(map(pattern.fullmatch, reasons)))
    return next(found, "")


def remedies_of(line: str) -> list[tuple[str, str]]:
    """The reasons of one press, joined by "; ", apart again, each with what to do about it; "" if unknown.

    A reason may hold "; " itself: what stands there is one reason where it is known as one.
    """
    words = line.split("; ") if line else []
    found: list[tuple[str, str]] = []
    while words:
        ends = (n for n in range(1, len(words) + 1) if known("; ".join(words[:n])) is not None)
        n = next(ends, 1)
        reason, words = "; ".join(words[:n]), words[n:]
        found.append((reason, remedy_of(reason)))
    return found


def known(reason: str) -> int | None:
    """The place of a reason in ``REMEDIES``; None where it has none."""
    return next((rank for rank, (pattern, _) in enumerate(_FOUND) if pattern.fullmatch(reason)), None)


_DESK = re.compile(r"study file|export the raw|align = |\[\[accept\]\]|names of the two|file name or path")


def at_the_desk(remedy: str) -> bool:
    """Whether the remedy is for the files, so that recording again would not help."""
    return bool(_DESK.search(remedy)) and "record again" not in remedy
