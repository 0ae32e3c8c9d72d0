// Drives CNCjs without its page, as its page does: opens the port, loads a job, runs it, holds,
// resumes, overrides. Prints a line a step, for senders.py.
//
//     cncjs.cjs PORT JOB TCP_PORT

const fs = require('fs');
const io = require('socket.io-client');
const jwt = require('jsonwebtoken');

const [port, job, tcp] = process.argv.slice(2);
const { secret } = JSON.parse(fs.readFileSync(`${process.env.HOME}/.cncrc`, 'utf8'));
const token = jwt.sign({ id: '', name: '' }, secret, { expiresIn: '1d' });
const socket = io(`ws://127.0.0.1:${tcp}`, { query: `token=${token}` });
const say = (...words) => console.log(...words);
const command = (...words) => socket.emit('command', port, ...words);

let begun = false;
socket.on('connect', () => socket.emit('open', port, { baudrate: 115200, controllerType: 'Grbl' }));
socket.on('connect_error', (error) => say('failed', String(error)));
socket.on('serialport:error', (error) => say('failed', JSON.stringify(error)));
socket.on('controller:state', (type, state) => {
  if (begun || !state.status || state.status.activeState !== 'Idle') return;
  begun = true;
  command('gcode:load', 'job.nc', fs.readFileSync(job, 'utf8'), {}, (error) => {
    say(error ? `failed ${error}` : 'loaded');
    command('gcode:start');
  });
});
socket.on('sender:status', (status) => {
  if (!status || !status.finishTime) return;
  say('finished', status.received);
  socket.emit('close', port);
  setTimeout(() => process.exit(0), 500);
});
// Orders by lines on standard input.
require('readline')
  .createInterface({ input: process.stdin })
  .on('line', (line) => command(...JSON.parse(line)));
