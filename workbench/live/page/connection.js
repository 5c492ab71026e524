// The socket of the bench: one question on its way, and of each subject the newest that waits.

import { unpack } from "/view/wire.js";

// Answers go to all pages: numbers of different pages must differ.
let number = Math.floor(Math.random() * 2 ** 40);
let onItsWay = 0;
let sent = null; // the row that is on its way
let since = 0; // [ms] when it was sent
let last = 0; // [ms] when something was asked for last
let single = 0;
let socket = null;
let slow = 0;
let told = () => {};
const SLOW = 1500; // [ms] after which it is said that an answer is waited for
const LOOKS = ["case", "envelope", "field", "film", "film_end", "frames", "gaps", "ghost", "measure", "motion", "near", "ready", "report", "report_end", "sit"];
const waiting = new Map();

// Ask for something; a newer question of the same subject replaces one that waits, but for one that
// ends a drag. each: whether it replaces none; or a text, and it replaces only one with the same text.
// then: is given the head of the answer, or null where a newer question has taken its place.
export function ask(verb, given = {}, each = false, then = () => {}) {
  const { person, joint, axis, limb, parts, controls } = given;
  const own = each === true ? (single += 1) : each || "";
  const subject = [verb, person, joint, axis, limb, parts, controls, own].join(" ");
  const before = waiting.get(subject);
  waiting.delete(subject); // what is asked last goes last
  if (before && before.question.done === true && given.done === false) waiting.set(`${subject} done`, before);
  else before?.then(null);
  waiting.set(subject, { question: { do: verb, ...given }, then });
  last = performance.now();
  next();
}

// Whether something was asked for after a time [ms].
export const askedAfter = (time) => last > time;

// Whether a question is on its way or waits.
export const waits = () => Boolean(onItsWay || waiting.size);

// Whether something that changes what is open is on its way or waits.
export const changes = () => [sent, ...waiting.values()].some((row) => row && !LOOKS.includes(row.question.do));

// For how long [ms] an answer has been waited for, 0 where none is.
export const waited = () => (onItsWay ? performance.now() - since : 0);

function next() {
  if (onItsWay || !waiting.size || socket?.readyState !== WebSocket.OPEN) return;
  const [subject, row] = waiting.entries().next().value;
  waiting.delete(subject);
  const { again } = row;
  row.number ??= number += 1;
  sent = row;
  onItsWay = row.number;
  since = performance.now();
  socket.send(JSON.stringify({ n: onItsWay, ...(again && { again }), ...row.question }));
  clearTimeout(slow);
  slow = setTimeout(() => told("the bench is at work; what is asked for the first time can take a minute"), SLOW);
}

// Connect, and again whenever the connection is lost. take: is given what arrives; say: is told how
// the connection is, and whether that is a fault.
export function connect(take, say) {
  told = say;
  socket = new WebSocket(`ws://${location.host}/ws`, "workbench-1");
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    say("");
    next();
  };
  socket.onmessage = (event) => {
    const found = answerOf(event.data);
    if (found.head.answers && found.head.answers === onItsWay) answered(found.head);
    take(found);
    next();
  };
  socket.onclose = async (event) => {
    askAgain();
    say(event.reason || (await lost()), true);
    if (event.code !== 4400) setTimeout(() => connect(take, say), 1000);
  };
}

// Why there is no connection: a bench that was started anew knows another secret than this page.
async function lost() {
  const reply = await fetch("/page/icon.svg", { method: "HEAD" }).catch(() => null);
  if (reply?.status === 403) return "the bench was started anew: open the address that it has printed";
  return "the bench does not answer; trying again";
}

function answered(head) {
  const { then } = sent;
  onItsWay = 0;
  sent = null;
  clearTimeout(slow);
  then(head);
}

// What was on its way when the connection was lost is asked first once there is another. The bench
// knows by the number what it has done already.
function askAgain() {
  clearTimeout(slow);
  onItsWay = 0;
  if (!sent) return;
  const rows = [...waiting];
  waiting.clear();
  waiting.set(`again ${(single += 1)}`, { ...sent, again: true });
  for (const [subject, row] of rows) waiting.set(subject, row);
  sent = null;
}

// The header of an answer, and its arrays by their names.
export function answerOf(buffer) {
  const { header: head, array } = unpack(buffer);
  return { head, arrays: Object.fromEntries(head.arrays.map(({ name }, k) => [name, array(k)])) };
}
