// The socket of the bench: one question on its way, and of each subject the newest that waits.

import { unpack } from "/view/wire.js";

// Answers go to all pages: numbers of different pages must differ.
let number = Math.floor(Math.random() * 2 ** 40);
let onItsWay = 0;
let since = 0; // [ms] when it was sent
let last = 0; // [ms] when something was asked for last
let single = 0;
let socket = null;
let slow = 0;
let told = () => {};
const SLOW = 1500; // [ms] after which it is said that an answer is waited for
const waiting = new Map();

// Ask for something; a newer question of the same subject replaces one that waits, but for one that
// ends a drag. each: whether it replaces none.
export function ask(verb, given = {}, each = false) {
  const { person, joint, axis, limb, parts, controls } = given;
  const subject = [verb, person, joint, axis, limb, parts, controls, each ? (single += 1) : ""].join(" ");
  const before = waiting.get(subject);
  waiting.delete(subject); // what is asked last goes last
  if (before && before.done === true && given.done === false) waiting.set(`${subject} done`, before);
  waiting.set(subject, { do: verb, ...given });
  last = performance.now();
  next();
}

// Whether something was asked for after a time [ms].
export const askedAfter = (time) => last > time;

// Whether a question is on its way or waits.
export const waits = () => Boolean(onItsWay || waiting.size);

// For how long [ms] an answer has been waited for, 0 where none is.
export const waited = () => (onItsWay ? performance.now() - since : 0);

function next() {
  if (onItsWay || !waiting.size || socket?.readyState !== WebSocket.OPEN) return;
  const [subject, question] = waiting.entries().next().value;
  waiting.delete(subject);
  number += 1;
  onItsWay = number;
  since = performance.now();
  socket.send(JSON.stringify({ n: number, ...question }));
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
    if (found.head.answers === onItsWay) answered();
    take(found);
    next();
  };
  socket.onclose = async (event) => {
    answered();
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

function answered() {
  onItsWay = 0;
  clearTimeout(slow);
}

// The header of an answer, and its arrays by their names.
export function answerOf(buffer) {
  const { header: head, array } = unpack(buffer);
  return { head, arrays: Object.fromEntries(head.arrays.map(({ name }, k) => [name, array(k)])) };
}
